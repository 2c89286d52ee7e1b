// What may be done with the estimates of a fit, and why.
#pragma once

#include "fit/fit_result.h"

namespace tribotrack::fit::internal {

/// Fills FitResult::verdict and verdict_reasons from all else that the result says. Not converged, not
/// identifiable, scatter that dominates, or chi^2 that rejects the model (p < 0.001 before any scatter was
/// added) and that nothing explains: do not use. Rejected, and explained by one thing or by what repeated
/// runs show: use with care. Other doubts likewise. Else: use.
void judge(FitResult& result);

/// From chi2, dof, p_value and scatter of a result.
Agreement agreement(const FitResult& result);

/// "a tilt of 1.01(3) mrad", "run 'a' 9 sd off".
std::string sentence_of(const Explanation& explanation);

}  // namespace tribotrack::fit::internal
