// The line of work that `run`, `fit` and `watch` share: every run tracked and measured, then what they share
// compared, so that one fit can be made to all of them (fit_stage.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/fit_stage.h"
#include "apps/files/campaign/campaign.h"
#include "apps/program/context.h"
#include "apps/recording/recording.h"
#include "apps/run/run.h"
#include "fit/estimate.h"

namespace tribotrack::apps {

/// Is told of the frames of a run's recording that have been worked on, and of all.
using FramesDone = std::function<void(std::int64_t done, std::int64_t total)>;

/// In what `run` and `fit` differ.
struct LineOfWork {
  /// Fills in the track of a run that has one.
  std::function<void(Run& run, const FramesDone& frames_done)> track;
  std::filesystem::path
      measurements;  ///< folder for each run's measurement, NAME.json; empty: none is written
  /// Names the runs that failed; throws where they are too many.
  std::function<void(const std::vector<Run>& runs)> name_failed;
};

/// Every run tracked and measured, with the scale and the conditions that they share. Large recordings come
/// first, on the command's threads, and progress is shown. A run whose work throws anything, lack of memory
/// included, has failed; the others go on. Throws InvalidInput where the campaign contradicts its recordings.
FittedCampaign measured(const Campaign& campaign, const LineOfWork& line, const Context& context);

// One run by itself, as `run` tracks it: what a job on another machine does.

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

/// "squares", "huber".
const std::vector<std::string>& losses();

/// Throws InvalidInput for the first of more failed runs than are allowed (those that are allowed for are
/// told on stderr, unless quiet), fit::DataError.
FittedCampaign fit_campaign(const Campaign& campaign, const FitChoices& choices, const Context& context);

}  // namespace tribotrack::apps
