// A loss that outliers cannot pull.
#pragma once

#include "fit/estimate.h"
#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

/// psi(s)/s for a run or point s standard deviations away (the length of its two whitened residuals):
///   Huber   1 up to s = 2, 2/s beyond            (of good data in the plane 86 % lie below 2)
///   Cauchy  1/(1 + s^2/9)                        (forgets what is far away)
double robust_weight(double s, Loss loss);

/// Weights of summary runs and trajectory points from their residuals without the present weights.
Weights robust_weights(const Residuals& residuals, const Eigen::VectorXd& values, const Linearised& at,
                       Loss loss);

/// The factor on (J'J)^-1, J unweighted, that makes it the covariance of an M-estimate (Huber 1981, eq.
/// 7.6.5): K^2 [sum psi^2/(n - p)]/[mean psi']^2, K = 1 + p/n var psi'/(mean psi')^2.
double robust_covariance_factor(const Residuals& residuals, const Linearised& at, Loss loss);

/// A sentence on what that means.
const char* robust_meaning(Loss loss);

}  // namespace tribotrack::fit::internal
