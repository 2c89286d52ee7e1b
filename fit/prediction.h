// What the model and a fit say of motions that were not filmed: for curves in reports.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fit/measurement.h"
#include "fit/problem.h"
#include "model/scenario.h"
#include "model/trajectory.h"

namespace tribotrack::fit {

/// The model's displacement over the run's cycles, m.
Eigen::Vector2d modelled_displacement(const model::Scenario& scenario);

/// Estimates and their covariance, SI, in the order of `parameters`.
struct FittedParameters {
  std::vector<FitParameter> parameters;
  Eigen::VectorXd estimates;
  Eigen::MatrixXd covariance;
};

/// The displacement of a scenario at the fitted values, to first order in the parameters' errors: with G =
/// d(displacement)/ d(parameters) its covariance is G C G'. alpha and v follow as in a measurement. A scale
/// moves what is measured, not what is modelled: it adds nothing. Throws model::InvalidParameter for a
/// scenario without a motion, and model::StepLimitExceeded where `max_steps` steps of the model are not
/// enough: friction next to nothing takes thousands of cycles to settle.
Displacement predicted_displacement(const model::Scenario& fitted, const FittedParameters& known,
                                    long max_steps = model::IntegrationOptions{}.max_steps);

}  // namespace tribotrack::fit
