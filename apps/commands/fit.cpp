// tribotrack fit: friction parameters from the runs of a campaign.
#include <fmt/format.h>

#include <memory>

#include "apps/campaign/fit_json.h"
#include "apps/campaign/fit_stage.h"
#include "apps/commands/command.h"
#include "apps/files/run_folder.h"
#include "apps/fitting/fit_campaign.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "apps/usage/wrong_usage.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

struct FitCommandOptions {
  std::string campaign, output, tracks, measurements, part;
  bool require_all = false, json = false, explain = false;
  FitChoices choices;
};

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

void fit_command(const FitCommandOptions& options, Context& context) {
  if (options.require_all && options.choices.allow_missing > 0)
    throw UsageError("give --require-all or --allow-missing, not both");
  const Campaign campaign = campaign_of_part(read_campaign(campaign_file(options.campaign)), options.part);
  check_output(campaign, options);
  FitChoices choices = options.choices;
  choices.tracks = options.tracks;
  choices.measurements = options.measurements;
  choices.result = options.output;
  const auto [runs, stage] = fit_campaign(campaign, choices, context);
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
  command.add_option("--part", options->part, "Which of the campaign's several [[part]]")->type_name("NAME");
  command
      .add_option("--measurements", options->measurements,
                  "Also write what was measured in each run's track, NAME.json (DIR/measurements of `run`)")
      ->type_name("DIR");
  command.add_flag("--require-all", options->require_all, "Every run must be usable (the default)");
  command
      .add_option("--allow-missing", options->choices.allow_missing, "Go on when up to N runs are not usable")
      ->type_name("N")
      ->check(whole_number(0));
  command
      .add_option("--bootstrap", options->choices.fit.bootstrap,
                  "Also intervals by refitting N simulated campaigns (400 give their ends to about 10 %)")
      ->type_name("N")
      ->check(whole_number(20, 1'000'000));
  command
      .add_option("--seed", options->choices.fit.bootstrap_seed,
                  "Seed of the bootstrap; recorded in the result")
      ->type_name("N");
  command
      .add_option("--loss", options->choices.loss,
                  "squares (default); huber or cauchy: outlying runs and points are down-weighted; what that "
                  "means for the intervals is printed with them")
      ->check(one_of(losses()))
      ->type_name("LOSS");
  command.add_flag("--compare-models", options->choices.fit.rivals,
                   "Compare tilt and alternative friction laws even where the residuals give no reason to");
  command.add_flag("--json", options->json, "Print the result as one JSON object");
  command.add_flag("--explain", options->explain,
                   "Print the whole report: residuals, correlations, what was left out");
  add_common(command, context,
             "  tribotrack fit campaign.toml -o fit.json\n  tribotrack fit campaign.toml --tracks out/tracks "
             "-o fit.json --json\n\nA campaign may give KEY_sd beside each quantity (amplitude_mm_sd, "
             "gravity_m_s2_sd, phi_rad_sd, ...): the "
             "intervals count it. Values without one are taken as exact and listed in fit.json.");
  command.callback([options, &context] { fit_command(*options, context); });
}

}  // namespace tribotrack::apps
