#include "apps/pipeline/campaign_runner.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/utsname.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "apps/campaign/fit_json.h"
#include "apps/campaign/fit_stage.h"
#include "apps/files/tracks/any_track.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/recording/job.h"
#include "apps/report/report.h"
#include "apps/text/output_file.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

namespace {

constexpr const char* kStopped =
    "stopped: finished recordings are kept, and the same command goes on from there";

void carry_out(CampaignRunner& runner) {
  runner.take_folder();
  const LastWords stopped(kStopped);
  runner.measure_runs();
  runner.share_scale();
  runner.refuse_if_none_is_left();
  runner.share_conditions();
  runner.fit_all();
  runner.report();
  runner.write_log();
}

/// At the end those go again that are still empty.
struct MadeFolders {
  std::vector<std::filesystem::path> folders;
  ~MadeFolders() {
    std::error_code in_use;
    for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder)
      std::filesystem::remove(*folder, in_use);
  }
};

std::string csv_rows(const std::string& part, const Json& fit) {
  std::string rows;
  for (const auto& [name, p] : fit.at("parameters").items())
    rows += fmt::format("{},{},{},{},{},{}\n", part, name, p.at("estimate").dump(), p.at("sd").dump(),
                        p.at("ci95").at(0).dump(), p.at("ci95").at(1).dump());
  return rows;
}

}  // namespace

void run_campaign(const Campaign& campaign, const RunnerOptions& options, bool plan_only, Context& context) {
  CampaignRunner runner(options, campaign, context);
  if (plan_only) return runner.print_plan();
  carry_out(runner);
  runner.print_result();
}

void run_part_by_part(const Campaign& campaign, const RunnerOptions& options, bool plan_only,
                      Context& context) {
  const std::filesystem::path root = options.output;
  const std::filesystem::path table = root / "parts.csv";
  MadeFolders made;
  if (!plan_only) {
    made.folders = create_folder(root);
    require_writable({{table}}, campaign.input_files());
  }
  Json fits = Json::object();
  std::string rows = "part,parameter,estimate,sd,ci95_low,ci95_high\n";
  for (const Campaign& part : campaigns_by_part(campaign)) {
    const std::string& name = part.part.name;
    RunnerOptions here = options;
    here.output = (root / name).string();
    CampaignRunner runner(here, part, context);
    if (!options.json) print("{}part {}\n", fits.empty() ? "" : "\n", name);
    if (plan_only) {
      runner.print_plan();
      fits[name] = nullptr;
      continue;
    }
    try {
      carry_out(runner);
    } catch (const InvalidInput& error) {
      complain(fmt::format("part {}: {}", name, error.what()));
      context.exit_code = kQualityGate;
      continue;
    }
    if (options.json)
      runner.say_what_happened();
    else
      runner.print_result();
    fits[name] = runner.fit().json;
    rows += csv_rows(name, runner.fit().json);
  }
  if (plan_only) return;
  if (fits.empty())
    throw InvalidInput(
        fmt::format("{}: none of its parts can be fitted; each is named above", options.campaign));
  write_file(table, rows);
  if (options.json) return print_text(text_of({{"parts", fits}}));
  print("\nparts  {}\n", table.string());
}

namespace fs = std::filesystem;

namespace {

double seconds_since(std::chrono::steady_clock::time_point begun) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

}  // namespace

CampaignRunner::CampaignRunner(const RunnerOptions& options, Campaign campaign, Context& context)
    : options_(options),
      context_(context),
      campaign_(std::move(campaign)),
      folder_{options.output},
      logs_(campaign_.runs.size()) {}

void CampaignRunner::print_plan() const {
  for (const CampaignRun& run : campaign_.runs) {
    std::string step =
        run.track ? "measure the track " + run.track->string() : "use alpha_rad, v_mm_s as given";
    if (run.video) {
      if (!may_be_recording(*run.video))
        step = fmt::format("cannot: there is no recording {}", run.video->string());
      else
        step = is_complete(run, prepare(job_for(campaign_, run)).key) ? "skip tracking: its track is current"
                                                                      : "track, measure";
    }
    print("{:<28} {}\n", run.name, step);
  }
  std::vector<std::string> names;
  for (const auto parameter : campaign_.fit.parameters) names.emplace_back(fit::to_string(parameter));
  print("{:<28} fit {} to {} runs -> {}\n{:<28} -> {}\n", "fit", fmt::format("{}", fmt::join(names, ", ")),
        campaign_.runs.size(), folder_.fit().string(), "report", folder_.report().string());
}

void CampaignRunner::take_folder() {
  if (const auto writer = options_.wait ? writer_of(folder_) : std::nullopt)
    say(context_.quiet, fmt::format("waiting for {}: it is writing into {}", *writer, folder_.root.string()));
  if (!options_.locked) lock_.emplace(folder_, options_.campaign, options_.wait);
  std::vector<Output> outputs = {{folder_.fit()},  {folder_.report()},          {folder_.runs_table()},
                                 {folder_.text()}, {folder_.parameter_table()}, {folder_.log()}};
  for (const CampaignRun& run : campaign_.runs) {
    outputs.push_back({folder_.measurement(run.name)});
    if (run.has_track()) outputs.push_back({folder_.track(run.name)});
    if (!run.video) continue;
    for (const fs::path& pictures :
         {folder_.first_frame(run.name), folder_.overlay(run.name), folder_.overlay_video(run.name)})
      outputs.push_back({pictures, Content::pictures});
  }
  require_writable(outputs, campaign_.input_files());
  for (const fs::path& folder : {folder_.root, folder_.tracks(), folder_.measurements()})
    remove_leftovers(folder);
  std::vector<std::string> names;
  for (const CampaignRun& run : campaign_.runs) names.push_back(run.name);
  folder_.take_back(names);
  if (const auto others = folder_.put_aside_all_but(names); !others.empty())
    say(context_.quiet,
        fmt::format("note: {} {} not in {}: moved to {}; should {} come back, so will the results",
                    fmt::join(others, ", "), others.size() == 1 ? "is" : "are", options_.campaign,
                    folder_.aside().root.string(), others.size() == 1 ? "it" : "they"));
}

void CampaignRunner::measure_runs() {
  runs_ = for_each_run(campaign_, context_, [this](std::size_t index, const FramesDone& frames_done) {
    return carry_out(index, frames_done);
  });
}

Run CampaignRunner::carry_out(std::size_t index, const FramesDone& frames_done) {
  const CampaignRun& run = campaign_.runs[index];
  const auto begun = std::chrono::steady_clock::now();
  struct Stopwatch {
    const std::chrono::steady_clock::time_point begun;
    double& seconds;
    ~Stopwatch() { seconds = seconds_since(begun); }
  } const stopwatch{begun, logs_[index].seconds};
  std::optional<Track> track;
  if (run.video) track = track_of(run, frames_done, logs_[index]);
  if (run.track) track = import_track(*run.track, run.reading, folder_.track(run.name));
  Run analysed = analyse(campaign_, run, std::move(track));
  write_measurement(analysed);
  return analysed;
}

/// The track that is there, if it is current, else one made now.
Track CampaignRunner::track_of(const CampaignRun& run, const FramesDone& frames_done, RunLog& log) const {
  if (!may_be_recording(*run.video))
    throw InvalidInput(fmt::format("{}: run \"{}\": there is no recording {}; check `video`", run.place,
                                   run.name, run.video->string()));
  require_trace(run);
  PreparedJob job = prepare(job_for(campaign_, run));
  job.job.track.progress = frames_done;
  // Runs are shared among the threads; where there are fewer runs than threads, a run takes several.
  const std::size_t to_track = options_.new_recordings > 0 ? options_.new_recordings : campaign_.runs.size();
  job.job.track.threads =
      std::max(1, threads_to_use(context_) / static_cast<int>(std::max<std::size_t>(1, to_track)));
  log.skipped = is_complete(run, job.key);
  if (log.skipped) return read_track_file(folder_.track(run.name));
  const auto begun = std::chrono::steady_clock::now();
  TrackedRecording recording = track_recording(job, folder_.track(run.name));
  log.frames_per_second = static_cast<double>(recording.result.summary.frames) / seconds_since(begun);
  for (const auto& stage : recording.result.stage_times) log.stage_seconds[stage.name] = stage.seconds;
  write_pictures(run, recording);  // first: the track's meta file marks the run as done
  const Input csv = write_track(folder_.track(run.name), job, recording);
  Track track = apps::track_of(job, recording);
  track.inputs = {csv};
  return track;
}

bool CampaignRunner::is_complete(const CampaignRun& run, const std::string& key) const {
  return is_current(folder_.track(run.name), key) && fs::exists(folder_.first_frame(run.name)) &&
         (!options_.overlay_videos || fs::exists(folder_.overlay_video(run.name)));
}

void CampaignRunner::write_pictures(const CampaignRun& run, TrackedRecording& recording) const {
  const auto jpeg = vision::first_frame_jpeg(*recording.source, recording.result.track.first_seen());
  write_file(folder_.first_frame(run.name), {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()},
             Content::pictures);
  for (const fs::path& overlay : {folder_.overlay(run.name), folder_.overlay_video(run.name)}) {
    if (overlay.extension() == ".mp4" && !options_.overlay_videos) continue;
    write_overlay_file(overlay, recording);
  }
}

void CampaignRunner::write_measurement(const Run& run) const {
  if (run.measurement && run.track)
    write_file(folder_.measurement(run.given.name), text_of(measurement_json(*run.measurement, *run.track)));
}

void CampaignRunner::share_scale() {
  shared_.scale = apps::share_scale(campaign_, runs_);
  if (!shared_.scale || !shared_.scale->used) return;
  for (const Run& run : runs_)
    if (run.failure.empty()) write_measurement(run);
}

void CampaignRunner::share_conditions() {
  shared_.conditions = apps::share_conditions(campaign_, runs_);
}

void CampaignRunner::refuse_if_none_is_left() {
  const bool none_left = failed() == runs_.size();
  if (none_left && runs_.size() == 1) throw InvalidInput(runs_.front().failure);
  for (const Run& run : runs_)
    if (!run.failure.empty()) complain(run.failure);
  if (none_left)
    throw InvalidInput(fmt::format("{}: none of its {} runs can be used; each is named above",
                                   options_.campaign, runs_.size()));
}

fit::FitResult CampaignRunner::preview(const fit::FitResult* last) const {
  const fit::Problem problem = problem_of(campaign_, runs_, shared_.conditions);
  fit::FitOptions options;
  options.profiles = false;
  options.threads = threads_to_use(context_);
  return last != nullptr ? fit::estimate_from(*last, problem, options) : fit::estimate(problem, options);
}

void CampaignRunner::fit_all() {
  fit_ = fit_runs(campaign_, runs_, shared_, context_);
}

void CampaignRunner::report() const {
  const MetaFile meta = meta_of_fit(campaign_, runs_);
  write_fit(folder_.fit(), fit_, meta);
  const Report report = report_of({fit_.json, meta.json(), runs_, folder_});
  write_file(folder_.runs_table(), report.runs_csv);
  write_file(folder_.parameter_table(), report.parameters_csv);
  write_file(folder_.text(), report.text);
  write_file(folder_.report(), report.page);
}

void CampaignRunner::write_log() const {
  Json json;
  json["finished"] = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  utsname host{};
  uname(&host);
  json["host"] = host.nodename;
  json["machine"] = host.machine;
  json["threads"] = threads_to_use(context_);
  json["command"] =
      fmt::format("tribotrack {} {} -o {}", options_.command, options_.campaign, options_.output);
  json["seconds"] = seconds_since(begun_);
  json["runs"] = Json::array();
  for (std::size_t k = 0; k < runs_.size(); ++k)
    json["runs"].push_back({{"name", runs_[k].given.name},
                            {"skipped_as_current", logs_[k].skipped},
                            {"seconds", logs_[k].seconds},
                            {"frames_per_second", logs_[k].frames_per_second},
                            {"stage_seconds", logs_[k].stage_seconds},
                            {"failure", runs_[k].failure}});
  write_file(folder_.log(), text_of(json));
}

void CampaignRunner::print_result() const {
  if (options_.json)
    print_text(text_of(fit_.json));
  else
    print("{}{}report {}\n", parameter_table(fit_.json), slide_table(fit_.json), folder_.report().string());
  say_what_happened();
}

void CampaignRunner::say_what_happened() const {
  if (skipped() > 0)
    say(context_.quiet, fmt::format("{} of {} tracks were current and were kept", skipped(), runs_.size()));
  if (failed() > 0) {
    complain(fmt::format("{} of {} runs failed and were left out", failed(), runs_.size()));
    context_.exit_code = kQualityGate;
  }
  report_fit(campaign_, fit_, options_.explain, "the report", context_);
}

std::size_t CampaignRunner::failed() const {
  return static_cast<std::size_t>(
      std::count_if(runs_.begin(), runs_.end(), [](const Run& run) { return !run.failure.empty(); }));
}

std::size_t CampaignRunner::skipped() const {
  return static_cast<std::size_t>(
      std::count_if(logs_.begin(), logs_.end(), [](const RunLog& log) { return log.skipped; }));
}

}  // namespace tribotrack::apps
