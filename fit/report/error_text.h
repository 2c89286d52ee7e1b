// What the errors counted in the covariance are, in words and numbers.
#pragma once

#include "fit/estimate.h"
#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

constexpr double kSurprise = 1e-3;  ///< p below which chance does not explain chi^2

constexpr double kDoubt = 0.05;  ///< p below which a scatter between runs is counted in the covariance

/// Scatter of runs and points, and which covariance is printed. `allowed`: a scatter could have been
/// estimated.
void tell_scatter(const Residuals& residuals, bool allowed, FitResult& result);
/// Slow errors of driven tracks.
void tell_slow_errors(const Residuals& residuals, FitResult& result);

}  // namespace tribotrack::fit::internal
