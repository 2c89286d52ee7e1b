// The errors that the covariance counts: numbers and sentences.
#pragma once

#include "fit/estimate.h"
#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

/// Scatter of runs and points, and which covariance is printed. `allowed`: a scatter could have been
/// estimated.
void fill_excess_variance(const Residuals& residuals, bool allowed, FitResult& result);
/// Correlated errors of driven tracks. After fill_excess_variance().
void fill_correlated_errors(const Residuals& residuals, FitResult& result);

}  // namespace tribotrack::fit::internal
