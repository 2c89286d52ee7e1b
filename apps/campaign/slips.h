// Last, where a fit fails or is absurd: what may have been typed wrongly.
#pragma once

#include <string>
#include <vector>

#include "apps/campaign/shared_conditions.h"
#include "apps/files/campaign/campaign.h"
#include "apps/run/run.h"
#include "fit/fit_result.h"
#include "fit/slips.h"

namespace tribotrack::apps {

/// What the campaign states and no recording shows.
fit::Typed typed(const std::vector<Run>& runs, const fit::Conditions& conditions);

/// "a slip would explain it: 0.56 is 0.28 mm peak to peak: with amplitude_mm = 0.28 ...": the slips `found`,
/// and where lengths go by one scale alone the advice to give a second one. Empty for a sound fit.
std::vector<std::string> likely_slips(const Campaign& campaign, const std::vector<Run>& runs,
                                      const SharedConditions& shared,
                                      const std::vector<fit::SlipFound>& found, const fit::FitResult& result);

}  // namespace tribotrack::apps
