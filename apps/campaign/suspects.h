// Then, where the fit is not usable: the runs whose label or kind may be wrong.
#pragma once

#include <string>
#include <vector>

#include "fit/fit_result.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// Sentences; empty where nothing is found, or the fit is usable.
/// - A free slide whose points lie off the fitted slide by more than a tenth of its way.
/// - Two runs with whose phi_rad, or phi_rad and dtau_rad, exchanged chi^2 falls a hundredfold, where at most
///   one other exchange does so too. Up to 6 runs: in more, they stand out one by one (FitResult::outliers).
std::vector<std::string> suspicious_runs(const fit::Problem& problem, const fit::FitResult& result,
                                         int threads);

}  // namespace tribotrack::apps
