// One run of a campaign by itself, as `run` tracks it: what a job on another machine does.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "apps/files/campaign/campaign.h"
#include "apps/files/track_file.h"
#include "apps/recording/recording.h"

namespace tribotrack::apps {

/// The run of that name. Throws InvalidInput, with the names there are, for another one and for a run that
/// has nothing to track.
const CampaignRun& run_named(const Campaign& campaign, const std::string& name);

/// The recording of a run, checked. Throws InvalidInput where it, or the run's oscilloscope trace, is not
/// there.
Recording checked_recording(const Campaign& campaign, const CampaignRun& run);

/// Does the work that ends in a run's track. Where the recording cannot be used, a sentence is left in place
/// of the track (RunFolder::failure_beside()), for the fit to repeat, before the exception goes on. No word
/// is left where the output cannot be written or memory is short: the same job may do better elsewhere.
void leaving_word(const CampaignRun& run, const std::filesystem::path& track,
                  const std::function<void()>& work);

/// What a job of its own has made of a run. Throws what it left word of where there is no track.
Track track_of_job(const std::filesystem::path& csv);

}  // namespace tribotrack::apps
