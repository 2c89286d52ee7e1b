// tribotrack fit: friction parameters from the runs of a campaign.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "apps/campaign/fit_json.h"
#include "apps/campaign/fit_stage.h"
#include "apps/commands/command.h"
#include "apps/commands/wrong_usage.h"
#include "apps/files/run_folder.h"
#include "apps/files/tracks/any_track.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/recording/job.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

const std::vector<std::string> kLosses = {"squares", "huber", "cauchy"};  ///< in the order of fit::Loss

struct FitCommandOptions {
  std::string campaign, output, tracks, loss = "squares";
  bool require_all = false, json = false, explain = false;
  int allow_missing = 0;
  fit::FitOptions fit;
};

/// The track of a run: from the folder the user names, else made here.
std::optional<TrackFile> track_of(const Campaign& campaign, const CampaignRun& run,
                                  const FitCommandOptions& options, const FramesDone& frames_done) {
  if (run.track) return read_any_track(*run.track, run.reading);
  if (!run.video) return std::nullopt;
  if (!options.tracks.empty()) return read_track_file(RunFolder::track_in(options.tracks, run.name));
  PreparedJob job = prepare(job_for(campaign, run));
  job.job.track.progress = frames_done;
  TrackFile track =
      track_file_of(job, track_recording(job, fs::path(options.output).parent_path() / (run.name + ".csv")));
  track.inputs = job.inputs;
  return track;
}

/// Refuses to write over what is read, and into the folder of a `run` that is under way.
void check_output(const Campaign& campaign, const FitCommandOptions& options) {
  if (is_standard_output(options.output)) {
    if (options.json) throw UsageError("give -o - or --json: both would go to standard output");
    return;
  }
  std::vector<fs::path> inputs = campaign.input_files();
  if (!options.tracks.empty())
    for (const CampaignRun& run : campaign.runs) {
      inputs.push_back(RunFolder::track_in(options.tracks, run.name));
      inputs.push_back(inputs.back().string() + ".meta.json");
    }
  require_writable({{options.output}}, inputs);
  const RunFolder folder{fs::path(options.output).parent_path()};
  if (const auto writer = writer_of(folder))
    throw InvalidInput(fmt::format(
        "{}: a run is writing into its folder: {}; wait until it has finished, or give another output",
        options.output, *writer));
}

/// Names the runs that failed; throws for the first of more than are allowed.
void allow_for_missing(const std::vector<AnalysedRun>& runs, const FitCommandOptions& options,
                       const Context& context) {
  int missing = 0;
  for (const AnalysedRun& run : runs) {
    if (run.failure.empty()) continue;
    if (++missing > options.allow_missing)
      throw InvalidInput(
          options.allow_missing == 0
              ? runs.size() == 1 ? run.failure : run.failure + " (--allow-missing 1 goes on without this run)"
              : fmt::format("{} (more than {} runs are missing)", run.failure, options.allow_missing));
    say(context.quiet, "left out: " + run.failure);
  }
}

void fit_command(const FitCommandOptions& options, Context& context) {
  if (options.require_all && options.allow_missing > 0)
    throw UsageError("give --require-all or --allow-missing, not both");
  const Campaign campaign = read_campaign(campaign_file(options.campaign));
  check_output(campaign, options);
  std::vector<AnalysedRun> runs =
      for_each_run(campaign, context, [&](std::size_t index, const FramesDone& frames_done) {
        const CampaignRun& run = campaign.runs[index];
        return analyse(campaign, run, track_of(campaign, run, options, frames_done));
      });
  SharedFindings shared;
  shared.scale = share_scale(campaign, runs);
  allow_for_missing(runs, options, context);
  shared.conditions = share_conditions(campaign, runs);
  const FitStage stage = fit_runs(campaign, runs, std::move(shared), context, options.fit);
  write_fit(options.output, stage, meta_of_fit(campaign, runs));
  if (!is_standard_output(options.output))
    print_text(options.json ? text_of(stage.json) : parameter_table(stage.json) + slide_table(stage.json));
  report_fit(campaign, stage, options.explain, "identifiability and next_experiment in " + options.output,
             context);
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
      ->check(whole_number(0));
  command
      .add_option("--bootstrap", options->fit.bootstrap,
                  "Also intervals by refitting N simulated campaigns (400 give their ends to about 10 %)")
      ->type_name("N")
      ->check(whole_number(20, 1'000'000));
  command.add_option("--seed", options->fit.bootstrap_seed, "Seed of the bootstrap; recorded in the result")
      ->type_name("N");
  command
      .add_option("--loss", options->loss,
                  "squares (default); huber or cauchy: outlying runs and points are down-weighted; what that "
                  "means for the intervals is printed with them")
      ->check(one_of(kLosses))
      ->type_name("LOSS");
  command.add_flag("--compare-models", options->fit.rivals,
                   "Compare tilt and alternative friction laws even where the residuals give no reason to");
  command.add_flag("--json", options->json, "Print the result as one JSON object");
  command.add_flag("--explain", options->explain,
                   "Print the whole report: residuals, correlations, what was left out");
  add_common(command, context,
             "  tribotrack fit campaign.toml -o fit.json\n  tribotrack fit campaign.toml --tracks out/tracks "
             "-o fit.json --json\n\nA campaign may give KEY_sd beside each quantity (amplitude_mm_sd, "
             "gravity_m_s2_sd, phi_rad_sd, ...): the "
             "intervals count it. Values without one are taken as exact and listed in fit.json.");
  command.callback([options, &context] {
    const auto loss = std::find(kLosses.begin(), kLosses.end(), options->loss);
    options->fit.loss = static_cast<fit::Loss>(loss - kLosses.begin());
    fit_command(*options, context);
  });
}

}  // namespace tribotrack::apps
