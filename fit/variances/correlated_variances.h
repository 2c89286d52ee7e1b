// How large the slow errors are: restricted maximum likelihood over all runs jointly.
#pragma once

#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

struct SlowEstimate {
  SlowVariances variances{};  ///< m^2; 0 where the residuals do not ask for the part
  SlowVariances sd{};         ///< of the variances
  /// Of each unknown's variance, as Student's t needs it (Satterthwaite): 2 V^2 / var V. Infinite without
  /// slow errors.
  Eigen::VectorXd degrees_of_freedom;
};

/// What the residuals r at the minimum and their Jacobian J, all whitened but for slow errors, say of V = I +
/// U G U': the variances that maximise
///   -1/2 (ln |V| + ln |J' V^-1 J| + r' P r),  P = V^-1 - V^-1 J (J' V^-1 J)^-1 J' V^-1
/// [Patterson and Thompson, Biometrika 58 (1971) 545; Harville, JASA 72 (1977) 320], which counts the
/// freedom that unknowns and start points take. Fisher's scoring, variances not below 0. A part that raises
/// twice the log-likelihood by less than 4 (6 for what all runs share) is left out: it is not told from none.
/// `residuals` hold a first guess.
SlowEstimate estimate_slow_errors(const Residuals& residuals, const Eigen::VectorXd& values);

}  // namespace tribotrack::fit::internal
