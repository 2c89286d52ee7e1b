// Excess variance: scatter beyond the data's own sigma.
#pragma once

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

/// Tracking noise is far below what runs differ by. The scatter that makes chi^2 equal to its expectation at
/// the present minimum: one between summary runs; one between the points of each trajectory run, with the
/// correlation time of its residuals (neighbouring points share their error: their number overstates their
/// information). Zero where chi^2 does not require it: p >= 0.001 of points; p >= 0.05 of runs, whose
/// correlated tracking errors may be as large as their own sigma, which so few cannot show. With a robust
/// loss that of the runs by the median distance, which a minority of outliers cannot move.
ExcessVariance estimate_excess_variance(const Residuals& residuals, const Eigen::VectorXd& values,
                                        const Linearised& at, Loss loss = Loss::squares);

/// What runs with the same phi, dtau, drive, start and length scatter about their means, whatever the model
/// predicts: chi^2 keeps its meaning beside it.
struct Replicates {
  double scatter = 0;  ///< m per axis beyond their own sigma; 0 where they do not require it (p >= 0.001)
  int dof = 0;         ///< two for each repetition
};
Replicates replicates(const Problem& problem);

}  // namespace tribotrack::fit::internal
