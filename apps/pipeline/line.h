// The line of work that `run`, `fit` and `watch` share: every run tracked and measured, then what they share
// compared, so that one fit can be made to all of them (fit_stage.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "apps/campaign/fit_stage.h"
#include "apps/files/campaign/campaign.h"
#include "apps/program/context.h"
#include "apps/run/run.h"

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

}  // namespace tribotrack::apps
