// The goals of `watch --until` as text.
#pragma once

#include <string>
#include <vector>

#include "fit/goal.h"

namespace tribotrack::apps {

/// "mu1=1%,mu2=3%,phase_lag_rad=0.5deg". Throws UsageError.
std::vector<fit::Goal> goals_from(const std::string& text);

/// "mu1 to 1 %: 0.46 %; mu2 to 3 %: reached, 1.2 %".
std::string progress_of(const std::vector<fit::Goal>& goals, const fit::FitResult& result);

/// Throws UsageError where a goal names a parameter that is not among those fitted.
void require_fitted(const std::vector<fit::Goal>& goals, const std::vector<fit::FitParameter>& fitted);

}  // namespace tribotrack::apps
