// One run of a campaign by itself, as `run` tracks it: what a job on another machine does.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "apps/files/campaign/campaign.h"
#include "apps/recording/track_recording.h"

namespace tribotrack::apps {

/// The run of that name. Throws InvalidInput, with the names there are, for another one and for a run that
/// has nothing to track.
const CampaignRun& run_named(const Campaign& campaign, const std::string& name);

/// How the recording of a run is to be tracked. Throws InvalidInput where it, or the run's oscilloscope
/// trace, is not there.
PreparedJob prepare_run(const Campaign& campaign, const CampaignRun& run);

/// The first analysed frame in which the part is seen, reduced, as it stands in the report.
void write_first_frame(const std::filesystem::path& picture, const TrackedRecording& recording);

/// Does the work that ends in a run's track. Where the recording cannot be used, a sentence is left in place
/// of the track (RunFolder::failure_beside()), for the fit to repeat, before the exception goes on. No word
/// is left where the output cannot be written or memory is short: the same job may do better elsewhere.
void leaving_word(const CampaignRun& run, const std::filesystem::path& track,
                  const std::function<void()>& work);

}  // namespace tribotrack::apps
