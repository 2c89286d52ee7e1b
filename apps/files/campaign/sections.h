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

// Keys of [fit] and [[run]] with values of their own kind.
void read_parameters(StrictTable& table, FitSection& fit, const std::filesystem::path& folder);
Json written_parameters(const FitSection& fit);
void read_exact(StrictTable& table, FitSection& fit, const std::filesystem::path& folder);
Json written_exact(const FitSection& fit);
void read_frames(StrictTable& table, CampaignRun& run, const std::filesystem::path& folder);
Json written_frames(const CampaignRun& run);
/// A trace, or two of an oscilloscope that writes a file for each channel.
void read_scope_files(StrictTable& table, CampaignRun& run, const std::filesystem::path& folder);
Json written_scope_files(const CampaignRun& run);
/// Where each of several parts lies at first.
void read_parts(StrictTable& table, CampaignRun& run, const std::filesystem::path& folder);

/// Refuses a run of a video in which the size of a pixel is not known.
void require_scale(const Campaign& campaign, const CampaignRun& run);

/// Gives a name to each run without one: the stem of its recording, numbered where it is taken.
void name_runs(std::vector<CampaignRun>& runs);

}  // namespace tribotrack::apps
