#include "apps/pipeline/line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <new>
#include <numeric>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/campaign/compared_runs.h"
#include "apps/campaign/conditions.h"
#include "apps/files/run_folder.h"
#include "apps/files/tracks/any_track.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/recording/recording.h"
#include "apps/recording/track.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"
#include "model/parallel.h"
#include "vision/frame_sink.h"

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

Recording checked_recording(const Campaign& campaign, const CampaignRun& run) {
  if (!may_be_recording(*run.video))
    throw InvalidInput(fmt::format("{}: run \"{}\": there is no recording {}; check `video`", run.place,
                                   run.name, run.video->string()));
  require_trace(run);
  return checked(recording_of(campaign, run));
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

/// Of each run's recording: what its work is measured by.
std::vector<std::uintmax_t> bytes_of(const Campaign& campaign) {
  std::vector<std::uintmax_t> bytes;
  for (const CampaignRun& run : campaign.runs) {
    std::error_code not_a_file;
    const std::uintmax_t size = run.video ? std::filesystem::file_size(*run.video, not_a_file) : 0;
    bytes.push_back(not_a_file ? 0 : size);
  }
  return bytes;
}

/// Large recordings first: one that began last would leave the other threads without work.
std::vector<std::size_t> order_of_work(const std::vector<std::uintmax_t>& bytes) {
  std::vector<std::size_t> order(bytes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t k) { return bytes[k]; });
  return order;
}

/// Written again where the runs' common scale has changed it.
void write_measurement(const std::filesystem::path& folder, const Run& run) {
  if (folder.empty() || !run.measurement || !run.track) return;
  write_file(folder / (run.given.name + ".json"), text_of(measurement_json(*run.measurement, *run.track)));
}

/// Nothing of a failed run is kept but how far the work went.
Run failed(Run run, const std::exception& error) {
  Run left;
  left.failure = failure_of(run.given, error);
  left.given = std::move(run.given);
  left.log = std::move(run.log);
  return left;
}

std::vector<Run> tracked_and_measured(const Campaign& campaign, const LineOfWork& line,
                                      const Context& context) {
  std::vector<Run> runs(campaign.runs.size());
  for (std::size_t k = 0; k < runs.size(); ++k) runs[k].given = campaign.runs[k];
  const std::vector<std::uintmax_t> bytes = bytes_of(campaign);
  const std::vector<std::size_t> order = order_of_work(bytes);
  RunsProgress progress(bytes, progress_style(context.quiet));
  std::mutex mutex;
  std::vector<Run> first;  // to finish: what all of them contradict is a slip in the campaign
  const std::size_t enough = std::min<std::size_t>(2, runs.size());
  parallel_for(runs.size(), threads_to_use(context), [&](std::size_t k) {
    const std::size_t index = order[k];
    Run& run = runs[index];
    const auto begun = std::chrono::steady_clock::now();
    try {
      line.track(run, [&](std::int64_t done, std::int64_t total) {
        progress.update(index, done, total);
        context.tell("track " + run.given.name, done, total);
      });
      measure(campaign, run);
      write_measurement(line.measurements, run);
    } catch (const OutputError&) {
      throw;  // a full disk is no fault of this run
    } catch (const vision::OutputError&) {
      throw;
    } catch (const std::exception& error) {
      run = failed(std::move(run), error);
    }
    run.log.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    progress.finish(index);
    const std::lock_guard lock(mutex);
    if (first.size() < enough && run.failure.empty() && run.measurement) {
      first.push_back(run);
      if (first.size() == enough) require_no_slips(campaign, first);
    }
  });
  return runs;
}

}  // namespace

FittedCampaign measured(const Campaign& campaign, const LineOfWork& line, const Context& context) {
  if (!line.measurements.empty()) create_folder(line.measurements);
  FittedCampaign fitted;
  fitted.runs = tracked_and_measured(campaign, line, context);
  fitted.scale = share_scale(campaign, fitted.runs);
  if (fitted.scale && fitted.scale->pooled.one_scale)
    for (const Run& run : fitted.runs)
      if (run.failure.empty()) write_measurement(line.measurements, run);
  line.name_failed(fitted.runs);
  fitted.conditions = share_conditions(campaign, fitted.runs);
  return fitted;
}

namespace {

/// What a job of its own has made of a run. Throws what it left word of where there is no track.
Track track_of_job(const std::filesystem::path& csv) {
  const std::filesystem::path word = RunFolder::failure_beside(csv);
  std::string sentence;
  if (!std::filesystem::exists(csv) && std::filesystem::is_regular_file(word)) sentence = read_text(word);
  while (sentence.ends_with('\n')) sentence.pop_back();
  if (!sentence.empty()) throw InvalidInput(sentence);
  return read_track_file(csv);
}

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

}  // namespace

const std::vector<std::string>& losses() {
  static const std::vector<std::string> words = {"squares", "huber"};  // in the order of fit::Loss
  return words;
}

FittedCampaign fit_campaign(const Campaign& campaign, const FitChoices& choices, const Context& context) {
  fit::FitOptions options = choices.fit;
  options.loss = static_cast<fit::Loss>(std::ranges::find(losses(), choices.loss) - losses().begin());
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
