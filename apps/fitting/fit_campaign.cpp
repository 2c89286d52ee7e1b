#include "apps/fitting/fit_campaign.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/files/run_folder.h"
#include "apps/files/tracks/any_track.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/recording/job.h"
#include "apps/recording/track_recording.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"
#include "vision/frame_sink.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

const CampaignRun& run_named(const Campaign& campaign, const std::string& name) {
  constexpr std::size_t kFew = 12;
  const auto found = std::ranges::find(campaign.runs, name, &CampaignRun::name);
  if (found == campaign.runs.end()) {
    std::vector<std::string> names;
    for (const CampaignRun& run : campaign.runs)
      if (names.size() < kFew) names.push_back(run.name);
    throw InvalidInput(fmt::format("{}: has no run \"{}\"; its runs are {}{}", campaign.file.string(), name,
                                   fmt::join(names, ", "), campaign.runs.size() > kFew ? ", ..." : ""));
  }
  if (!found->has_track())
    throw InvalidInput(
        fmt::format("{}: run \"{}\" was measured elsewhere: there is nothing to track", found->place, name));
  return *found;
}

PreparedJob prepare_run(const Campaign& campaign, const CampaignRun& run) {
  if (!may_be_recording(*run.video))
    throw InvalidInput(fmt::format("{}: run \"{}\": there is no recording {}; check `video`", run.place,
                                   run.name, run.video->string()));
  require_trace(run);
  return prepare(job_for(campaign, run));
}

void write_first_frame(const std::filesystem::path& picture, const TrackedRecording& recording) {
  const auto jpeg = vision::first_frame_jpeg(*recording.source, recording.result.track.first_seen());
  write_file(picture, {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()}, Content::pictures);
}

void leaving_word(const CampaignRun& run, const std::filesystem::path& track,
                  const std::function<void()>& work) {
  const std::filesystem::path word = RunFolder::failure_beside(track);
  try {
    work();
  } catch (const OutputError&) {
    throw;
  } catch (const vision::OutputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    write_file(word, failure_of(run, error) + "\n");
    throw;
  }
  std::error_code none;
  std::filesystem::remove(word, none);
}

namespace {

/// What a job of its own has made of a run. Throws what it left word of where there is no track.
Track track_from_job(const std::filesystem::path& csv) {
  const std::filesystem::path word = RunFolder::failure_beside(csv);
  std::string sentence;
  if (!std::filesystem::exists(csv) && std::filesystem::is_regular_file(word)) sentence = read_text(word);
  while (sentence.ends_with('\n')) sentence.pop_back();
  if (!sentence.empty()) throw InvalidInput(sentence);
  return read_track_file(csv);
}

/// As `run` writes them into its folder.
void write_measurements(const std::filesystem::path& folder, const std::vector<Run>& runs) {
  create_folder(folder);
  for (const Run& run : runs)
    if (run.failure.empty() && run.measurement && run.track)
      write_file(folder / (run.given.name + ".json"),
                 text_of(measurement_json(*run.measurement, *run.track)));
}

/// The track of a run: from the folder the user names, else made here.
std::optional<Track> track_of(const Campaign& campaign, const CampaignRun& run, const FitChoices& choices,
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
  Track track = apps::track_of(job, track_recording(job, beside));
  track.inputs = job.inputs;
  return track;
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
