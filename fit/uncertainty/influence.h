// How much of a result rests on one run.
#pragma once

#include <Eigen/Core>

#include "fit/minimum/minimise.h"
#include "fit/uncertainty/covariance.h"

namespace tribotrack::fit::internal {

/// The change of each reported parameter (columns) if a run (rows: summary runs, then trajectory runs) were
/// left out, in standard deviations of the parameter: to first order (J'J - J_i'J_i)^-1 J_i' r_i with J_i,
/// r_i the run's whitened rows [Belsley, Kuh and Welsch, Regression Diagnostics, 1980, section 2.1]. NaN
/// where the others alone do not determine it.
Eigen::MatrixXd influence_of_runs(const Residuals& residuals, const Minimum& best,
                                  const Uncertainty& uncertainty);

}  // namespace tribotrack::fit::internal
