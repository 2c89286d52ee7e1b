// The size of correlated errors: restricted maximum likelihood over all runs jointly.
#pragma once

#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

struct CorrelatedEstimate {
  CorrelatedVariances variances{};  ///< m^2; 0 where the residuals do not require the part
  /// Of the variance of each unknown that all runs share, as Student's t needs it (Satterthwaite): 2 V^2 /
  /// var V. Infinite without correlated errors.
  Eigen::VectorXd degrees_of_freedom;
  double log_likelihood = 0;  ///< restricted, of these variances, but for a constant of the points
};

/// From the residuals r at the minimum and their Jacobian J, whitened but for correlated errors, with V = I +
/// U G U': the variances that maximise
///   -1/2 (ln |V| + ln |J' V^-1 J| + r' P r),  P = V^-1 - V^-1 J (J' V^-1 J)^-1 J' V^-1
/// [Patterson and Thompson, Biometrika 58 (1971) 545; Harville, JASA 72 (1977) 320], which counts the
/// freedom that unknowns and start points take. Fisher's scoring, variances not below 0. All are 0 where
/// together they raise twice the log-likelihood by less than chance does in 2 % of campaigns. `residuals`
/// hold a first guess.
CorrelatedEstimate estimate_correlated_errors(const Residuals& residuals, const Eigen::VectorXd& values);

}  // namespace tribotrack::fit::internal
