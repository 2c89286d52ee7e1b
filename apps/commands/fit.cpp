// tribotrack fit: friction parameters from the runs of a campaign.
#include <fmt/format.h>

#include <cstdlib>
#include <memory>

#include "apps/campaign/fit_json.h"
#include "apps/campaign/shared_scale.h"
#include "apps/commands/command.h"
#include "apps/program/parallel.h"
#include "apps/program/progress.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

struct FitCommandOptions {
  std::string campaign, output, tracks;
  bool require_all = false, json = false, explain = false;
  int allow_missing = 0;
  fit::FitOptions fit;
};

/// The track of a run: from the folder the user names, else made here.
std::optional<TrackFile> track_of(const Campaign& campaign, const CampaignRun& run,
                                  const FitCommandOptions& options, const fs::path& scratch) {
  if (!run.video) return std::nullopt;
  if (!options.tracks.empty()) return read_track_file(fs::path(options.tracks) / (run.name + ".csv"));
  const RecordingJob job = job_for(campaign, run);
  const TrackedRecording recording = track_recording(job);
  if (!recording.result.summary.gate_passed)
    throw InvalidInput(fmt::format("{}: run \"{}\": the part was lost in {} of {} frames", run.place,
                                   run.name, recording.result.summary.lost_counted,
                                   recording.result.summary.frames));
  const fs::path csv = scratch / (run.name + ".csv");
  write_track(csv, job, recording);
  return read_track_file(csv);
}

/// A folder for the tracks of this call, gone at its end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "tribotrack-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      throw InvalidInput(fmt::format("{}: no temporary folder can be made there; set TMPDIR", name));
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::vector<AnalysedRun> analyse_all(const Campaign& campaign, const FitCommandOptions& options,
                                     const Context& context) {
  const ScratchFolder scratch;
  std::vector<AnalysedRun> runs(campaign.runs.size());
  Progress progress("runs", context.quiet);
  std::atomic<long> done = 0;
  const auto count = static_cast<long>(runs.size());
  for_each_index(count, threads_to_use(context), [&](long k) {
    const auto index = static_cast<std::size_t>(k);
    const CampaignRun& run = campaign.runs[index];
    try {
      runs[index] = analyse(campaign, run, track_of(campaign, run, options, scratch.path()));
    } catch (const std::runtime_error& error) {
      runs[index].run = &run;
      runs[index].failure = error.what();
    }
    progress.update(++done, count);
  });
  return runs;
}

void fit_command(const FitCommandOptions& options, Context& context) {
  if (options.require_all && options.allow_missing > 0)
    throw UsageError("give --require-all or --allow-missing, not both");
  const Campaign campaign = read_campaign(options.campaign);
  require_writable(options.output);
  std::vector<AnalysedRun> runs = analyse_all(campaign, options, context);
  int missing = 0;
  for (const AnalysedRun& run : runs)
    if (!run.failure.empty()) {
      if (++missing > options.allow_missing)
        throw InvalidInput(options.allow_missing == 0 ? run.failure
                                                      : fmt::format("{} (more than {} runs are missing)",
                                                                    run.failure, options.allow_missing));
      say(context.quiet, "left out: " + run.failure);
    }

  const std::optional<SharedScale> shared = share_scale(campaign, runs);
  const fit::FitResult result = fit_campaign(campaign, runs, context, options.fit);
  Json json = fit_json(campaign, runs, result);
  add_to(json, shared);
  MetaFile meta;
  meta.command = "fit";
  meta.inputs = {options.campaign};
  for (const CampaignRun& run : campaign.runs)
    if (run.video && fs::exists(*run.video)) meta.inputs.push_back(*run.video);
  meta.configuration = campaign.effective_configuration();
  write_file(options.output, text_of(json));
  meta.write_beside(options.output);
  if (options.json)
    fmt::print("{}", text_of(json));
  else
    fmt::print("{}", parameter_table(json));
  say(context.quiet, options.explain ? result.full_report() : result.brief_report());
  for (const Json& warning : json["warnings"]) say(context.quiet, "warning: " + warning.get<std::string>());
  if (!result.usable()) {
    fmt::print(
        stderr, "tribotrack: {}: the fit is not usable: {}\n", options.campaign,
        result.converged
            ? "the data do not tell these parameters apart; see identifiability and next_experiment in " +
                  options.output
            : "it did not converge; give first guesses in [fit.start]");
    for (const std::string& sentence : remedies(result)) fmt::print(stderr, "  {}\n", sentence);
    context.exit_code = kFitUnusable;
  }
}

}  // namespace

void add_fit(CLI::App& app, Context& context) {
  auto options = std::make_shared<FitCommandOptions>();
  CLI::App& command = *app.add_subcommand("fit", "Fit mu1, mu2 and the phase lag to the runs of a campaign");
  command.add_option("CAMPAIGN", options->campaign, "The campaign file")
      ->type_name("CAMPAIGN.toml")
      ->required();
  command.add_option("-o,--output", options->output, "The result")->type_name("fit.json")->required();
  command
      .add_option("--tracks", options->tracks,
                  "Folder with the runs' tracks, NAME.csv (DIR/tracks of `run`); without it the videos are "
                  "tracked now")
      ->type_name("DIR");
  command.add_flag("--require-all", options->require_all, "Every run must be usable (the default)");
  command.add_option("--allow-missing", options->allow_missing, "Go on when up to N runs are not usable")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--bootstrap", options->fit.bootstrap,
                  "Also intervals by refitting N simulated campaigns (400 give their ends to about 10 %)")
      ->type_name("N")
      ->check(CLI::Range(20, 1'000'000));
  command.add_option("--seed", options->fit.bootstrap_seed, "Of the bootstrap's noise; told in the result")
      ->type_name("N");
  command
      .add_option("--loss", options->fit.loss,
                  "squares (default); huber or cauchy: far runs and points pull less; what that means for "
                  "the intervals is told with them")
      ->transform(CLI::CheckedTransformer(std::map<std::string, fit::Loss>{
          {"squares", fit::Loss::squares}, {"huber", fit::Loss::huber}, {"cauchy", fit::Loss::cauchy}}))
      ->type_name("LOSS");
  command.add_flag("--compare-models", options->fit.rivals,
                   "Compare tilt and rival friction laws even where the residuals do not ask for it");
  command.add_flag("--json", options->json, "Print the result as one JSON object");
  command.add_flag("--explain", options->explain,
                   "Print the whole report: residuals, correlations, what was left out");
  add_common(command, context,
             "  tribotrack fit campaign.toml -o fit.json\n  tribotrack fit campaign.toml --tracks out/tracks "
             "-o fit.json --json");
  command.callback([options, &context] { fit_command(*options, context); });
}

}  // namespace tribotrack::apps
