#include "apps/fitting/fit_campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "apps/files/run_folder.h"
#include "apps/files/tracks/any_track.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/recording/job.h"
#include "apps/recording/track_recording.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

/// What a job of its own has made of a run. Throws what it left word of where there is no track.
TrackFile track_from_job(const std::filesystem::path& csv) {
  const std::filesystem::path word = RunFolder::failure_beside(csv);
  std::string sentence;
  if (!std::filesystem::exists(csv) && std::filesystem::is_regular_file(word)) sentence = read_text(word);
  while (sentence.ends_with('\n')) sentence.pop_back();
  if (!sentence.empty()) throw InvalidInput(sentence);
  return read_track_file(csv);
}

/// As `run` writes them into its folder.
void write_measurements(const std::filesystem::path& folder, const std::vector<AnalysedRun>& runs) {
  create_folder(folder);
  for (const AnalysedRun& run : runs)
    if (run.failure.empty() && run.measurement && run.track)
      write_file(folder / (run.run->name + ".json"), text_of(measurement_json(*run.measurement, *run.track)));
}

/// The track of a run: from the folder the user names, else made here.
std::optional<TrackFile> track_of(const Campaign& campaign, const CampaignRun& run, const FitChoices& choices,
                                  const FramesDone& frames_done) {
  if (!run.has_track()) return std::nullopt;
  if (!choices.tracks.empty()) {
    const std::filesystem::path csv = RunFolder::track_in(choices.tracks, run.name);
    if (run.video || std::filesystem::exists(csv)) return track_from_job(csv);
  }
  if (run.track) return read_any_track(*run.track, run.reading);
  PreparedJob job = prepare(job_for(campaign, run));
  job.job.track.progress = frames_done;
  std::optional<std::filesystem::path> beside;
  if (choices.result) beside = choices.result->parent_path() / (run.name + ".csv");
  TrackFile track = track_file_of(job, track_recording(job, beside));
  track.inputs = job.inputs;
  return track;
}

/// Names the runs that failed; throws for the first of more than are allowed.
void allow_for_missing(const std::vector<AnalysedRun>& runs, int allowed, const Context& context) {
  int missing = 0;
  for (const AnalysedRun& run : runs) {
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
    throw UsageError(fmt::format("--loss must be squares, huber or cauchy, not \"{}\"", word));
  return static_cast<fit::Loss>(found - losses().begin());
}

}  // namespace

const std::vector<std::string>& losses() {
  static const std::vector<std::string> words = {"squares", "huber", "cauchy"};  // in the order of fit::Loss
  return words;
}

FittedCampaign fit_campaign(const Campaign& campaign, const FitChoices& choices, const Context& context) {
  fit::FitOptions options = choices.fit;
  options.loss = loss_named(choices.loss);
  FittedCampaign fitted;
  fitted.runs = for_each_run(campaign, context, [&](std::size_t index, const FramesDone& frames_done) {
    const CampaignRun& run = campaign.runs[index];
    return analyse(campaign, run, track_of(campaign, run, choices, frames_done));
  });
  SharedFindings shared;
  shared.scale = share_scale(campaign, fitted.runs);
  if (!choices.measurements.empty()) write_measurements(choices.measurements, fitted.runs);
  allow_for_missing(fitted.runs, choices.allow_missing, context);
  shared.conditions = share_conditions(campaign, fitted.runs);
  fitted.stage = fit_runs(campaign, fitted.runs, std::move(shared), context, options);
  return fitted;
}

}  // namespace tribotrack::apps
