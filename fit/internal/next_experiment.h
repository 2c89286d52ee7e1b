// Which run to film next.
#pragma once

#include <optional>

#include "fit/estimate.h"
#include "fit/internal/covariance.h"

namespace tribotrack::fit::internal {

/// Over a grid of phi and dtau with the drive and start of the runs: the run whose displacement, measured as
/// well as a typical run so far, shrinks the volume of the parameters' ellipsoid most (D-criterion; ranges
/// stand in for what is not pinned at all). nullopt without summary runs.
std::optional<NextExperiment> next_experiment(const Residuals& residuals, const Eigen::VectorXd& values,
                                              const Eigen::MatrixXd& jacobian, int threads);

}  // namespace tribotrack::fit::internal
