// [fit], [scope] and [[run]] of a campaign.
#pragma once

#include <filesystem>
#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/text/json.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

FitSection read_fit(StrictTable& table);
ScopeSection read_scope(StrictTable& table);

/// Of `start` in [fit] where a table of first guesses was meant.
inline constexpr const char* kGuessHint =
    "is a word, how the runs start; first guesses of parameters stand in the table [fit.guess]";

/// `campaign` holds what stands above the runs. Without `with_sds` alpha and v may stand without theirs.
/// Throws InvalidInput naming the place.
CampaignRun read_run(StrictTable& table, const Campaign& campaign, bool with_sds = true);

/// Refuses a run of a video in which the size of a pixel is not known.
void require_scale(const Campaign& campaign, const CampaignRun& run);

/// Gives a name to each run without one: the stem of its recording, numbered where it is taken.
void name_runs(std::vector<CampaignRun>& runs);

}  // namespace tribotrack::apps
