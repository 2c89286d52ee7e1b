#include "apps/pipeline/fit_campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "apps/files/run_folder.h"
#include "apps/files/tracks/any_track.h"
#include "apps/pipeline/job.h"
#include "apps/pipeline/line.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/recording/recording.h"
#include "apps/recording/track.h"

namespace tribotrack::apps {

namespace {

/// From the folder the user names, else made here.
Track track_of(const Campaign& campaign, const CampaignRun& run, const FitChoices& choices,
               const FramesDone& frames_done) {
  if (!choices.tracks.empty()) {
    const std::filesystem::path csv = RunFolder::track_in(choices.tracks, run.name);
    if (run.video || std::filesystem::exists(csv)) return track_of_job(csv);
  }
  if (run.track) return read_any_track(*run.track, run.reading);
  Recording recording = checked(recording_of(campaign, run));
  recording.options.progress = frames_done;
  std::optional<std::filesystem::path> beside;
  if (choices.result) beside = choices.result->parent_path() / (run.name + ".csv");
  return track_in(tracked(std::move(recording), beside));
}

/// Names the runs that failed; throws for the first of more than are allowed.
void allow_for_missing(const std::vector<Run>& runs, int allowed, const Context& context) {
  int missing = 0;
  for (const Run& run : runs) {
    if (run.failure.empty()) continue;
    if (++missing > allowed)
      throw InvalidInput(
          allowed == 0
              ? runs.size() == 1 ? run.failure : run.failure + " (--allow-missing 1 goes on without this run)"
              : fmt::format("{} (more than {} runs are missing)", run.failure, allowed));
    say(context.quiet, "left out: " + run.failure);
  }
}

fit::Loss loss_named(const std::string& word) {
  const auto found = std::ranges::find(losses(), word);
  if (found == losses().end())
    throw UsageError(fmt::format("--loss must be squares or huber, not \"{}\"", word));
  return static_cast<fit::Loss>(found - losses().begin());
}

}  // namespace

const std::vector<std::string>& losses() {
  static const std::vector<std::string> words = {"squares", "huber"};  // in the order of fit::Loss
  return words;
}

FittedCampaign fit_campaign(const Campaign& campaign, const FitChoices& choices, const Context& context) {
  fit::FitOptions options = choices.fit;
  options.loss = loss_named(choices.loss);
  LineOfWork line;
  line.track = [&](Run& run, const FramesDone& frames_done) {
    if (run.given.has_track()) run.track = track_of(campaign, run.given, choices, frames_done);
  };
  line.measurements = choices.measurements;
  line.name_failed = [&](const std::vector<Run>& runs) {
    allow_for_missing(runs, choices.allow_missing, context);
  };
  FittedCampaign fitted = measured(campaign, line, context);
  fit_runs(campaign, fitted, context, options);
  return fitted;
}

}  // namespace tribotrack::apps
