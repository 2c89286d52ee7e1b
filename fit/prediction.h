// What fitted parameters and their covariance predict of a run: the model's curve and its band in reports.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fit/measurement.h"
#include "fit/problem.h"

namespace tribotrack::fit {

/// Estimates and their covariance, SI, in the order of `parameters`.
struct FittedParameters {
  std::vector<FitParameter> parameters;
  Eigen::VectorXd estimates;
  Eigen::MatrixXd covariance;
};

/// The displacement of a scenario at the fitted values, to first order in the parameters' errors: with G =
/// d(displacement)/ d(parameters) its covariance is G C G'. alpha and v follow as in a measurement. A scale
/// moves what is measured, not what is modelled: it adds nothing. Throws model::InvalidParameter for a
/// scenario without a motion.
Displacement predicted_displacement(const model::Scenario& fitted, const FittedParameters& known);

}  // namespace tribotrack::fit
