#include "apps/pipeline/campaign_runner.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/utsname.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "apps/campaign/fit_stage.h"
#include "apps/files/tracks/any_track.h"
#include "apps/pipeline/line.h"
#include "apps/pipeline/manifest.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/recording/recording.h"
#include "apps/recording/track.h"
#include "apps/report/report.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

void carry_out(CampaignRunner& runner) {
  runner.take_folder();
  runner.measure();
  runner.fit_all();
  runner.report();
  runner.write_log();
}

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
  if (!plan_only) {
    create_folder(root);
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
      context.doubt(kQualityGate, fmt::format("part {}: {}", name, error.what()));
      continue;
    }
    if (options.json)
      runner.say_what_happened();
    else
      runner.print_result();
    fits[name] = runner.fitted().json;
    rows += csv_rows(name, runner.fitted().json);
  }
  if (plan_only) return;
  if (fits.empty())
    throw InvalidInput(
        fmt::format("{}: none of its parts can be fitted; each is named above", options.campaign));
  write_file(table, rows);
  if (options.json) return print_text(text_of({{"parts", fits}}));
  print("\nparts  {}\n", table.string());
}

namespace {

double seconds_since(std::chrono::steady_clock::time_point begun) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

}  // namespace

CampaignRunner::CampaignRunner(const RunnerOptions& options, Campaign campaign, Context& context)
    : options_(options), context_(context), campaign_(std::move(campaign)), folder_{options.output} {}

void CampaignRunner::print_plan() const {
  for (const CampaignRun& run : campaign_.runs) {
    std::string step =
        run.track ? "measure the track " + run.track->string() : "use alpha_rad, v_mm_s as given";
    if (run.video) {
      if (!may_be_recording(*run.video))
        step = fmt::format("cannot: there is no recording {}", run.video->string());
      else if (const auto why = why_outdated(run, checked(recording_of(campaign_, run))))
        step = why->empty() ? "track, measure" : "track again, measure: " + *why;
      else
        step = "skip tracking: its track is current";
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
    for (const fs::path& pictures : {folder_.first_frame(run.name), folder_.overlay(run.name)})
      outputs.push_back({pictures, Content::pictures});
  }
  require_writable(outputs, campaign_.input_files());
  for (const fs::path& folder : {folder_.root, folder_.tracks(), folder_.measurements()})
    remove_leftovers(folder);
  std::vector<std::string> names;
  for (const CampaignRun& run : campaign_.runs) names.push_back(run.name);
  for (const std::string& other : folder_.runs())
    if (std::ranges::count(names, other) == 0)
      say(context_.quiet, fmt::format("note: {} is not among the runs of {} with data: its files stay in {}",
                                      other, options_.campaign, folder_.tracks().string()));
}

void CampaignRunner::measure() {
  LineOfWork line;
  line.track = [this](Run& run, const FramesDone& frames_done) {
    const CampaignRun& given = run.given;
    if (given.video) run.track = track_of(given, frames_done, run.log);
    if (given.track) run.track = import_track(*given.track, given.reading, folder_.track(given.name));
  };
  line.measurements = folder_.measurements();
  line.name_failed = [this](const std::vector<Run>& runs) { name_failed(runs); };
  fitted_ = measured(campaign_, line, context_);
}

/// The track that is there, if it is current, else one made now.
Track CampaignRunner::track_of(const CampaignRun& given, const FramesDone& frames_done, Run::Log& log) const {
  const fs::path csv = folder_.track(given.name);
  Recording recording = checked_recording(campaign_, given);
  const auto why = why_outdated(given, recording);
  log.skipped = !why;
  if (log.skipped) return read_track_file(csv);
  log.again = *why;
  recording.options.progress = frames_done;
  // Runs are shared among the threads; where there are fewer runs than threads, a run takes several.
  const std::size_t to_track = options_.new_recordings > 0 ? options_.new_recordings : campaign_.runs.size();
  recording.options.threads =
      std::max(1, threads_to_use(context_) / static_cast<int>(std::max<std::size_t>(1, to_track)));
  const auto begun = std::chrono::steady_clock::now();
  recording = tracked(std::move(recording), csv);
  log.frames_per_second = static_cast<double>(recording.result.summary.frames) / seconds_since(begun);
  for (const auto& stage : recording.result.stage_times) log.stage_seconds[stage.name] = stage.seconds;
  // Pictures first: the track's meta file marks the run as done.
  write_first_frame(folder_.first_frame(given.name), recording);
  write_overlay_file(folder_.overlay(given.name), recording);
  const Input written = write_track(csv, recording);
  Track track = track_in(recording);
  track.inputs = {written};
  return track;
}

std::optional<std::string> CampaignRunner::why_outdated(const CampaignRun& run,
                                                        const Recording& recording) const {
  const auto why = apps::why_outdated(folder_.track(run.name), recording);
  return why || fs::exists(folder_.first_frame(run.name))
             ? why
             : std::optional<std::string>("its pictures are to be drawn");
}

void CampaignRunner::name_failed(const std::vector<Run>& runs) const {
  const bool none_left = std::ranges::none_of(runs, &std::string::empty, &Run::failure);
  if (none_left && runs.size() == 1) throw InvalidInput(runs.front().failure);
  for (const Run& run : runs)
    if (!run.failure.empty()) complain(run.failure);
  if (none_left)
    throw InvalidInput(fmt::format("{}: none of its {} runs can be used; each is named above",
                                   options_.campaign, runs.size()));
}

void CampaignRunner::fit_all() {
  fit_runs(campaign_, fitted_, context_);
}

void CampaignRunner::report() const {
  write_fit(folder_.fit(), campaign_, fitted_);
  const Report report = report_of(folder_);
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
  for (const Run& run : fitted_.runs)
    json["runs"].push_back({{"name", run.given.name},
                            {"skipped_as_current", run.log.skipped},
                            {"made_again", run.log.again},
                            {"seconds", run.log.seconds},
                            {"frames_per_second", run.log.frames_per_second},
                            {"stage_seconds", run.log.stage_seconds},
                            {"failure", run.failure}});
  std::vector<Input> inputs = {campaign_.input};
  inputs.insert(inputs.end(), campaign_.table_inputs.begin(), campaign_.table_inputs.end());
  std::vector<std::string> names;
  for (const Run& run : fitted_.runs) {
    if (!run.failure.empty()) continue;
    names.push_back(run.given.name);
    if (run.track) inputs.insert(inputs.end(), run.track->recorded_in.begin(), run.track->recorded_in.end());
    for (const Input& input : run.inputs)
      if (input.path != folder_.track(run.given.name)) inputs.push_back(input);
  }
  json["manifest"] = manifest_of(folder_, names, inputs);
  write_file(folder_.log(), text_of(json));
}

void CampaignRunner::print_result() const {
  if (options_.json)
    print_text(text_of(fitted_.json));
  else
    print("{}{}report {}\n", parameter_table(fitted_.json), slide_table(fitted_.json),
          folder_.report().string());
  say_what_happened();
}

void CampaignRunner::say_what_happened() const {
  const auto skipped = std::ranges::count_if(fitted_.runs, [](const Run& run) { return run.log.skipped; });
  if (skipped > 0)
    say(context_.quiet,
        fmt::format("{} of {} tracks were current and were kept", skipped, fitted_.runs.size()));
  for (const Run& run : fitted_.runs)
    if (!run.log.again.empty())
      say(context_.quiet, fmt::format("note: {} was tracked again: {}", run.given.name, run.log.again));
  if (failed() > 0)
    context_.doubt(kQualityGate,
                   fmt::format("{} of {} runs failed and were left out", failed(), fitted_.runs.size()));
  report_fit(campaign_, fitted_, options_.explain, "the report", context_);
}

std::size_t CampaignRunner::failed() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(fitted_.runs, [](const Run& run) { return !run.failure.empty(); }));
}

}  // namespace tribotrack::apps
