// tribotrack run: from a campaign's recordings to its report, every stage, resuming what is there.
#include <algorithm>
#include <memory>
#include <string>

#include "apps/commands/command.h"
#include "apps/pipeline/part_by_part.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "apps/usage/wrong_usage.h"
#include "apps/workflow/workflow.h"

namespace tribotrack::apps {

namespace {

struct RunOptions {
  std::string campaign, output, part, emit;
  bool dry_run = false, overlay_videos = false, explain = false, json = false, wait = false;
};

/// Jobs for a workflow engine instead of doing the work here.
void emit_workflow(const RunOptions& options, const Context& context) {
  const WorkflowOptions workflow = {options.campaign, options.output, std::max(1, context.threads)};
  write_workflow(workflow, campaign_of_part(read_campaign(campaign_file(options.campaign)), ""));
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
  const Campaign campaign = read_campaign(campaign_file(options.campaign));
  if (!options.part.empty() || campaign.parts.empty())
    return run_campaign(campaign_of_part(campaign, options.part), runner_options, options.dry_run, context);
  run_part_by_part(campaign, runner_options, options.dry_run, context);
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
  command
      .add_option("--part", options->part,
                  "Only this one of the campaign's several [[part]] (default: each, into DIR/NAME)")
      ->type_name("NAME");
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
