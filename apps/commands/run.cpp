// tribotrack run: from a campaign's recordings to its report, every stage, resuming what is there.
#include <fmt/format.h>
#include <sys/utsname.h>

#include <atomic>
#include <chrono>
#include <ctime>
#include <memory>

#include "apps/campaign/fit_json.h"
#include "apps/campaign/shared_scale.h"
#include "apps/commands/command.h"
#include "apps/files/run_folder.h"
#include "apps/program/parallel.h"
#include "apps/program/progress.h"
#include "apps/report/report.h"
#include "apps/text/output_file.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

struct RunOptions {
  std::string campaign, output;
  bool dry_run = false, overlay_videos = false, explain = false;
};

double seconds_since(std::chrono::steady_clock::time_point begun) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

/// How one run went, for run.json.
struct RunLog {
  bool skipped = false;  ///< its track was current
  bool gate_failed = false;
  double seconds = 0;
  double frames_per_second = 0;
};

/// Tracks a run's video unless the track that is there is current. Pictures first: the track's meta file
/// marks the run as done.
void bring_track_up_to_date(const Campaign& campaign, const CampaignRun& run, const RunFolder& folder,
                            const RunOptions& options, RunLog& log) {
  const RecordingJob job = job_for(campaign, run);
  if (!fs::exists(*run.video) && run.video->filename().string().find('%') == std::string::npos)
    throw InvalidInput(fmt::format("{}: run \"{}\": there is no recording {}; check `video`", run.place,
                                   run.name, run.video->string()));
  const fs::path csv = folder.track(run.name);
  log.skipped = is_current(csv, job.key()) && fs::exists(folder.first_frame(run.name)) &&
                (!options.overlay_videos || fs::exists(folder.overlay_video(run.name)));
  if (log.skipped) return;
  const auto begun = std::chrono::steady_clock::now();
  const TrackedRecording recording = track_recording(job);
  log.frames_per_second = static_cast<double>(recording.result.summary.frames) / seconds_since(begun);
  const auto source = vision::open_source(job.video, {job.frame_rate_hz});
  const auto png = vision::first_frame_png(*source, recording.result.track.first_seen());
  write_file(folder.first_frame(run.name), {reinterpret_cast<const char*>(png.data()), png.size()});
  for (const fs::path& overlay : {folder.overlay(run.name), folder.overlay_video(run.name)}) {
    if (overlay.extension() == ".mp4" && !options.overlay_videos) continue;
    TemporaryFile file(overlay);
    vision::write_overlay(*source, recording.result, file.name());
    file.commit();
  }
  write_track(csv, job, recording);
}

AnalysedRun carry_out(const Campaign& campaign, const CampaignRun& run, const RunFolder& folder,
                      const RunOptions& options, RunLog& log) {
  std::optional<TrackFile> track;
  if (run.video) {
    bring_track_up_to_date(campaign, run, folder, options, log);
    track = read_track_file(folder.track(run.name));
    const Json& summary = track->meta.at("summary");
    if (!summary.at("gate_passed").get<bool>()) {
      log.gate_failed = true;
      throw InvalidInput(
          fmt::format("{}: run \"{}\": the part was lost in {} of {} frames, more than allowed; look at {}",
                      run.place, run.name, summary.at("lost_counted").dump(), summary.at("frames").dump(),
                      folder.overlay(run.name).string()));
    }
  }
  AnalysedRun analysed = analyse(campaign, run, std::move(track));
  if (analysed.measurement)
    write_file(folder.measurement(run.name),
               text_of(measurement_json(*analysed.measurement, *analysed.track)));
  return analysed;
}

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

void print_plan(const Campaign& campaign, const RunFolder& folder) {
  for (const CampaignRun& run : campaign.runs) {
    std::string step = "use alpha_rad, v_mm_s as given";
    if (run.video) {
      if (!fs::exists(*run.video) && run.video->filename().string().find('%') == std::string::npos)
        step = fmt::format("cannot: there is no recording {}", run.video->string());
      else
        step = is_current(folder.track(run.name), job_for(campaign, run).key())
                   ? "skip tracking: its track is current"
                   : "track, measure";
    }
    fmt::print("{:<28} {}\n", run.name, step);
  }
  fmt::print("{:<28} fit {} to {} runs -> {}\n{:<28} -> {}\n", "fit",
             fmt::join(
                 [&] {
                   std::vector<std::string> names;
                   for (const auto parameter : campaign.fit.parameters)
                     names.emplace_back(fit::to_string(parameter));
                   return names;
                 }(),
                 ", "),
             campaign.runs.size(), folder.fit().string(), "report", folder.report().string());
}

void write_log(const RunFolder& folder, const RunOptions& options, const std::vector<AnalysedRun>& runs,
               const std::vector<RunLog>& logs, double seconds, int threads) {
  Json json;
  json["finished"] = now_utc();
  utsname host{};
  uname(&host);
  json["host"] = host.nodename;
  json["machine"] = host.machine;
  json["threads"] = threads;
  json["command"] = fmt::format("tribotrack run {} -o {}", options.campaign, options.output);
  json["seconds"] = seconds;
  json["runs"] = Json::array();
  for (std::size_t k = 0; k < runs.size(); ++k)
    json["runs"].push_back({{"name", runs[k].run->name},
                            {"skipped_as_current", logs[k].skipped},
                            {"seconds", logs[k].seconds},
                            {"frames_per_second", logs[k].frames_per_second},
                            {"failure", runs[k].failure}});
  write_file(folder.log(), text_of(json));
}

void run_command(const RunOptions& options, Context& context) {
  const auto begun = std::chrono::steady_clock::now();
  const Campaign campaign = read_campaign(options.campaign);
  const RunFolder folder{options.output};
  if (options.dry_run) return print_plan(campaign, folder);
  const bool made_here = !fs::exists(folder.root);
  create_folder(folder.tracks());
  create_folder(folder.measurement("x").parent_path());

  std::vector<AnalysedRun> runs(campaign.runs.size());
  std::vector<RunLog> logs(runs.size());
  {
    Progress progress("runs", context.quiet);
    std::atomic<long> done = 0;
    const auto count = static_cast<long>(runs.size());
    for_each_index(count, threads_to_use(context), [&](long k) {
      const auto index = static_cast<std::size_t>(k);
      const CampaignRun& run = campaign.runs[index];
      const auto run_begun = std::chrono::steady_clock::now();
      try {
        runs[index] = carry_out(campaign, run, folder, options, logs[index]);
      } catch (const std::runtime_error& error) {
        runs[index] = {};
        runs[index].run = &run;
        runs[index].failure = error.what();
      }
      logs[index].seconds = seconds_since(run_begun);
      progress.update(++done, count);
    });
  }

  std::size_t failed = 0, skipped = 0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    failed += !runs[k].failure.empty();
    skipped += logs[k].skipped;
  }
  const bool none_left = failed == runs.size();
  if (none_left) {
    std::error_code ignored;
    if (made_here) fs::remove_all(folder.root, ignored);
    if (failed == 1) throw InvalidInput(runs.front().failure);
  }
  for (const AnalysedRun& run : runs)
    if (!run.failure.empty()) fmt::print(stderr, "tribotrack: {}\n", run.failure);
  if (none_left)
    throw InvalidInput(fmt::format("{}: none of its {} runs can be used; each is named above",
                                   options.campaign, runs.size()));

  const std::optional<SharedScale> shared = share_scale(campaign, runs);
  if (shared && shared->used)
    for (const AnalysedRun& run : runs)
      if (run.measurement && run.track)
        write_file(folder.measurement(run.run->name),
                   text_of(measurement_json(*run.measurement, *run.track)));
  const fit::FitResult result = fit_campaign(campaign, runs, context);
  Json json = fit_json(campaign, runs, result);
  add_to(json, shared);
  MetaFile meta;
  meta.command = "fit";
  meta.inputs = {options.campaign};
  for (const AnalysedRun& run : runs)
    if (run.run->video && run.failure.empty()) meta.inputs.push_back(folder.track(run.run->name));
  meta.configuration = campaign.effective_configuration();
  write_file(folder.fit(), text_of(json));
  meta.write_beside(folder.fit());
  write_file(folder.report(), report_page({campaign, runs, result, shared, meta.json(), folder}));
  write_log(folder, options, runs, logs, seconds_since(begun), threads_to_use(context));

  fmt::print("{}report {}\n", parameter_table(json), folder.report().string());
  if (skipped > 0)
    say(context.quiet, fmt::format("{} of {} tracks were current and were kept", skipped, runs.size()));
  say(context.quiet, options.explain ? result.full_report() : result.brief_report());
  for (const Json& warning : json["warnings"]) say(context.quiet, "warning: " + warning.get<std::string>());
  if (failed > 0) {
    fmt::print(stderr, "tribotrack: {} of {} runs failed and were left out\n", failed, runs.size());
    context.exit_code = kQualityGate;
  }
  if (!result.usable()) {
    fmt::print(stderr, "tribotrack: {}: the fit is not usable: {}\n", options.campaign,
               result.converged ? "the data do not tell these parameters apart; see the report"
                                : "it did not converge; give first guesses in [fit.start]");
    for (const std::string& sentence : remedies(result)) fmt::print(stderr, "  {}\n", sentence);
    context.exit_code = kFitUnusable;
  }
}

}  // namespace

void add_run(CLI::App& app, Context& context) {
  auto options = std::make_shared<RunOptions>();
  CLI::App& command = *app.add_subcommand(
      "run", "All of it for every run of a campaign: track, measure, fit, report; resumes");
  command.add_option("CAMPAIGN", options->campaign, "The campaign file")
      ->type_name("CAMPAIGN.toml")
      ->required();
  command.add_option("-o,--output", options->output, "Folder for tracks, fit.json and report.html")
      ->type_name("DIR")
      ->required();
  command.add_flag("--dry-run", options->dry_run, "Print what would be done and stop");
  command.add_flag("--overlay-videos", options->overlay_videos,
                   "Also write a labelled video of every run (tracks/NAME.mp4)");
  command.add_flag("--explain", options->explain, "Print the whole fit report, and what was left out");
  add_common(command, context, "  tribotrack run data/example/campaign.toml -o out");
  command.callback([options, &context] { run_command(*options, context); });
}

}  // namespace tribotrack::apps
