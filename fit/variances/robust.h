// A loss that outliers cannot pull.
#pragma once

#include "fit/estimate.h"
#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

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

}  // namespace tribotrack::fit::internal
