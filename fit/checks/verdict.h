// What may be done with a fit.
#pragma once

#include <vector>

#include "fit/fit_result.h"

namespace tribotrack::fit::internal {

/// The intervals cover what the explanations say that are as good.
void widen(const std::vector<Explanation>& as_good, FitResult& result);

/// Fills FitResult::verdict and verdict_reasons from all else that the result says. Not converged, not
/// identifiable, scatter that dominates, or chi^2 that rejects the model (p < 0.001 before any scatter was
/// added) and that nothing explains: do not use. Rejected, and explained by one thing or by what repeated
/// runs show: use with care. Other doubts likewise. Else: use.
void judge(FitResult& result);

/// From chi2, dof, p_value and scatter of a result.
Agreement agreement(const FitResult& result);

}  // namespace tribotrack::fit::internal
