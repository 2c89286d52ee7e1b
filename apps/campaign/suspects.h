// Then, where the fit is not usable: the runs whose kind may be wrong.
#pragma once

#include <string>
#include <vector>

#include "fit/fit_result.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// A sentence for each free slide whose points lie off the fitted slide by more than a tenth of its way; empty
/// where the fit is usable.
std::vector<std::string> suspicious_runs(const fit::Problem& problem, const fit::FitResult& result);

}  // namespace tribotrack::apps
