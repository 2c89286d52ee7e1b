// Errors beyond the data's own sigma: scatter, robust weights, and the minimum, which depend on each other.
#pragma once

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"
#include "fit/residuals/residuals.h"
#include "fit/variances/correlated_variances.h"

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

// A loss that outliers cannot pull.

/// psi(s)/s for a run s standard deviations away (the length of its two whitened residuals): 1 up to s = 2,
/// 2/s beyond (Huber; of good data in the plane 86 % lie below 2).
double robust_weight(double s);

/// Weights of summary runs from their residuals without the present weights.
std::vector<double> robust_weights(const Residuals& residuals, const Linearised& at);

/// The factor on (J'J)^-1, J unweighted, that makes it the covariance of an M-estimate (Huber 1981, eq.
/// 7.6.5): K^2 [sum psi^2/(n - p)]/[mean psi']^2, K = 1 + p/n var psi'/(mean psi')^2.
double robust_covariance_factor(const Residuals& residuals, const Linearised& at);

/// A sentence on what that means.
const char* robust_meaning(Loss loss);

/// What is estimated beside the parameters.
struct Reweighting {
  bool correlated_errors = false;  ///< of driven trajectory runs
  bool scatter = false;            ///< of runs and points
  Loss loss = Loss::squares;
};

/// Descends from `best`, estimates correlated errors, scatter and weights there, and again, until none moves:
/// a few rounds. On return the residuals carry all of them.
CorrelatedEstimate reweighted_fit(Residuals& residuals, Minimum& best, const Reweighting& reweighting);

/// Of runs or points; correlated errors are not counted.
bool any(const ExcessVariance& scatter);

}  // namespace tribotrack::fit::internal
