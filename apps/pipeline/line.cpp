#include "apps/pipeline/line.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <numeric>
#include <system_error>
#include <utility>

#include "apps/campaign/compared_runs.h"
#include "apps/campaign/conditions.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "model/parallel.h"
#include "vision/frame_sink.h"

namespace tribotrack::apps {

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
  if (fitted.scale && fitted.scale->used)
    for (const Run& run : fitted.runs)
      if (run.failure.empty()) write_measurement(line.measurements, run);
  line.name_failed(fitted.runs);
  fitted.conditions = share_conditions(campaign, fitted.runs);
  return fitted;
}

}  // namespace tribotrack::apps
