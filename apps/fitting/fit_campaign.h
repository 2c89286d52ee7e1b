// One run of a campaign by itself, as `run` tracks it: what a job on another machine does.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/campaign/fit_stage.h"
#include "apps/files/campaign/campaign.h"
#include "apps/program/context.h"
#include "apps/recording/track_recording.h"
#include "fit/estimate.h"

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

// What `fit` does with a campaign: a track of every run, read or made, then one fit.

struct FitChoices {
  std::filesystem::path tracks;  ///< folder of the runs' tracks, NAME.csv; empty: videos are tracked now
  std::filesystem::path
      measurements;              ///< folder for each run's measurement, NAME.json; empty: none is written
  int allow_missing = 0;         ///< runs that may fail
  std::string loss = "squares";  ///< one of losses()
  /// Where a picture goes that asks which disc is the part: beside this result. Nothing: no picture.
  std::optional<std::filesystem::path> result;
  fit::FitOptions fit;  ///< bootstrap, its seed, rivals
};

/// "squares", "huber", "cauchy".
const std::vector<std::string>& losses();

struct FittedCampaign {
  std::vector<Run> runs;
  FitStage stage;
};

/// Throws InvalidInput for the first of more failed runs than are allowed (those that are allowed for are
/// told on stderr, unless quiet), UsageError for another loss, fit::DataError.
FittedCampaign fit_campaign(const Campaign& campaign, const FitChoices& choices, const Context& context);

}  // namespace tribotrack::apps
