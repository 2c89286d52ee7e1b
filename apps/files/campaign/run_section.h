// One [[run]] of a campaign.
#pragma once

#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/files/campaign/fit_section.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

/// `campaign` holds what stands above the runs. Throws InvalidInput naming the place.
CampaignRun read_run(StrictTable& table, const Campaign& campaign, const FitDefaults& defaults);

/// Refuses a run of a video in which the size of a pixel is not known.
void require_scale(const Campaign& campaign, const CampaignRun& run);

/// Gives a name to each run without one: the stem of its recording, numbered where it is taken.
void name_runs(std::vector<CampaignRun>& runs);

}  // namespace tribotrack::apps
