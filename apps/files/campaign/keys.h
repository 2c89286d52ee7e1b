// Every key that a campaign may hold: the one list from which campaigns are read, explained (`help campaign`,
// its JSON Schema), drafted (`init`) and written into meta files.
#pragma once

#include <string>
#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/files/keys.h"

namespace tribotrack::apps {

// The sections, in the order of a campaign.
const Keys<Campaign>& top_keys();
const Keys<PlatformSection>& platform_keys();
const Keys<PartSection>& part_keys();
const Keys<CameraSection>& camera_keys();
const Keys<ScopeSection>& scope_keys();
const Keys<DataSection>& data_keys();
const Keys<FitSection>& fit_keys();
const Keys<CampaignRun>& run_keys();

// [fit], [scope] and [[run]] of a campaign.

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

struct CampaignSection {
  std::string name;    ///< "platform", "fit.fixed", "run"; "" for what stands before all of them
  std::string remark;  ///< what it is for, one line
  std::vector<KeyFacts> keys;
  bool repeated = false;  ///< [[run]]
};

/// All of them; [fit.guess] and [fit.prior] take every parameter that can be fitted as they take mu1.
const std::vector<CampaignSection>& campaign_sections();

/// Of a parameter's value in [fit.fixed] and [fit.guess].
Kind kind_of(fit::FitParameter parameter);

/// The sections that hold a key: "platform", "run".
std::vector<std::string> sections_with(const std::string& key);

/// `help campaign`: all sections, keys, kinds of values and meanings.
std::string campaign_reference();

/// `help campaign --json`: the JSON Schema (draft 2020-12) of a campaign, as TOML maps to JSON.
Json campaign_schema();

}  // namespace tribotrack::apps
