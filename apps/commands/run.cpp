// tribotrack run: from a campaign's recordings to its report, every stage, resuming what is there.
#include <algorithm>
#include <memory>
#include <string>

#include "apps/commands/command.h"
#include "apps/pipeline/campaign_runner.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "apps/usage/wrong_usage.h"
#include "apps/workflow/workflow.h"

namespace tribotrack::apps {

namespace {

struct RunOptions {
  std::string campaign, output, emit;
  bool dry_run = false, overlay_videos = false, explain = false, json = false, wait = false;
};

/// Jobs for a workflow engine instead of doing the work here.
void emit_workflow(const RunOptions& options, const Context& context) {
  const WorkflowOptions workflow = {options.campaign, options.output, std::max(1, context.threads)};
  write_workflow(workflow, read_campaign(campaign_file(options.campaign)));
  print_text(workflow_commands(workflow));
}

void run_command(const RunOptions& options, Context& context) {
  if (!options.emit.empty()) return emit_workflow(options, context);
  const RunnerOptions runner_options = {.campaign = options.campaign,
                                        .output = options.output,
                                        .overlay_videos = options.overlay_videos,
                                        .explain = options.explain,
                                        .json = options.json,
                                        .wait = options.wait};
  CampaignRunner runner(runner_options, read_campaign(campaign_file(options.campaign)), context);
  if (options.dry_run) return runner.print_plan();
  runner.take_folder();
  const LastWords stopped("stopped: finished recordings are kept, and the same command goes on from there");
  runner.measure_runs();
  runner.share_scale();
  runner.refuse_if_none_is_left();
  runner.share_conditions();
  runner.fit_all();
  runner.report();
  runner.write_log();
  runner.print_result();
}

}  // namespace

void add_run(CLI::App& app, Context& context) {
  auto options = std::make_shared<RunOptions>();
  CLI::App& command = *app.add_subcommand(
      "run", "Run the whole pipeline on a campaign: track, measure, fit, report; resumes");
  command.add_option("CAMPAIGN", options->campaign, "The campaign file")
      ->type_name("CAMPAIGN.toml")
      ->required();
  command.add_option("-o,--output", options->output, "Folder for tracks, fit.json and report.html")
      ->type_name("DIR")
      ->required();
  command.add_flag("--dry-run", options->dry_run, "Print what would be done, and stop");
  command.add_flag("--overlay-videos", options->overlay_videos,
                   "Also write a labelled video of every run (tracks/NAME.mp4)");
  command.add_flag("--explain", options->explain, "Print the whole fit report, and what was left out");
  command
      .add_option("--emit", options->emit,
                  "Instead of doing the work, write it into DIR as jobs for a workflow engine, which spreads "
                  "them over a cluster: a Snakefile, and a profile for Slurm")
      ->check(one_of({"snakemake"}))
      ->type_name("snakemake");
  command.add_flag("--json", options->json, "Print the result as one JSON object");
  command.add_flag("--wait", options->wait, "Wait while another run is writing into DIR (default: refuse)");
  add_common(command, context,
             "  tribotrack run data/example/campaign.toml -o out\n\nA campaign may give KEY_sd beside each "
             "quantity (amplitude_mm_sd, gravity_m_s2_sd, phi_rad_sd, ...): the "
             "intervals count it. Values without one are taken as exact and listed in fit.json.");
  command.callback([options, &context] { run_command(*options, context); });
}

}  // namespace tribotrack::apps
