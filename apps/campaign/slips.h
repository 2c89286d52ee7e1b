// Last, where a fit fails or is absurd: what may have been typed wrongly.
#pragma once

#include <string>
#include <vector>

#include "apps/campaign/shared_conditions.h"
#include "apps/files/campaign/campaign.h"
#include "apps/run/run.h"
#include "fit/fit_result.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// "a slip would explain it: 0.56 is 0.28 mm peak to peak: with amplitude_mm = 0.28 ...": what
/// fit::find_slips finds, and where lengths go by one scale alone the advice to give a second one. Empty for
/// a sound fit. `problem`: its driven runs as displacements.
std::vector<std::string> likely_slips(const Campaign& campaign, const std::vector<Run>& runs,
                                      const SharedConditions& shared, const fit::Problem& problem,
                                      const fit::FitResult& result);

}  // namespace tribotrack::apps
