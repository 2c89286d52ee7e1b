// tribotrack run: from a campaign's recordings to its report, every stage, resuming what is there.
#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "apps/campaign/fit_stage.h"
#include "apps/commands/command.h"
#include "apps/files/run_folder.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/pipeline/campaign_runner.h"
#include "apps/pipeline/line.h"
#include "apps/pipeline/manifest.h"
#include "apps/program/called.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/report/report.h"
#include "apps/text/output_file.h"
#include "apps/usage/wrong_usage.h"
#include "apps/workflow/workflow.h"

namespace tribotrack::apps {

namespace {

struct RunOptions : RunnerOptions {
  std::string part, emit;
  bool dry_run = false;
};

/// Jobs for a workflow engine instead of doing the work here.
void emit_workflow(const RunOptions& options, const Context& context) {
  const WorkflowOptions workflow = {options.campaign, options.output, std::max(1, context.threads)};
  write_workflow(workflow, campaign_of_part(read_campaign(campaign_file(options.campaign)), ""));
  print_text(workflow_commands(workflow));
}

void run_command(const RunOptions& options, Context& context) {
  if (!options.emit.empty()) return emit_workflow(options, context);
  const Campaign campaign = read_campaign(campaign_file(options.campaign));
  if (!options.part.empty() || campaign.parts.empty())
    return run_campaign(campaign_of_part(campaign, options.part), options, options.dry_run, context);
  run_part_by_part(campaign, options, options.dry_run, context);
}

}  // namespace

void add_run(CLI::App& app, Context& context) {
  auto options = std::make_shared<RunOptions>();
  CLI::App& command = *app.add_subcommand(
      "run", "Run the whole pipeline on a campaign: track, measure, fit, report; resumes");
  add_option(command, "CAMPAIGN", options->campaign, "CAMPAIGN.toml", "The campaign file")->required();
  add_option(command, "-o,--output", options->output, "DIR",
             "Folder for tracks, fit.json and report.html (default: CAMPAIGN-out, beside the campaign)");
  add_option(command, "--part", options->part, "NAME",
             "Only this one of the campaign's several [[part]] (default: each, into DIR/NAME)");
  command.add_flag("--dry-run", options->dry_run, "Print what would be done, and stop");
  command.add_flag("--explain", options->explain, "Print the whole fit report, and what was left out");
  add_option(command, "--emit", options->emit, "snakemake",
             "Instead of doing the work, write it into DIR as jobs for a workflow engine, which spreads them "
             "over a cluster: a Snakefile, and a profile for Slurm")
      ->check(one_of({"snakemake"}));
  command.add_flag("--json", options->json, "Print the result as one JSON object");
  command.add_flag("--wait", options->wait, "Wait while another run is writing into DIR (default: refuse)");
  add_common(command, context, std::string("  tribotrack run data/example/campaign.toml") + kOfSds);
  command.callback([options, &context] {
    if (options->output.empty()) options->output = output_of(campaign_file(options->campaign)).string();
    run_command(*options, context);
  });
}

// tribotrack fit: friction parameters from the runs of a campaign.

namespace fs = std::filesystem;

namespace {

struct FitCommandOptions {
  std::string campaign, output, part;
  bool require_all = false, json = false, explain = false;
  FitChoices choices;
};

/// Refuses to write over what is read, and into the folder of a `run` that is under way.
void check_output(const Campaign& campaign, const FitCommandOptions& options) {
  if (is_printed(options.output, options.json)) return;
  std::vector<fs::path> inputs = campaign.input_files();
  if (!options.choices.tracks.empty())
    for (const CampaignRun& run : campaign.runs) {
      inputs.push_back(RunFolder::track_in(options.choices.tracks, run.name));
      inputs.push_back(inputs.back().string() + ".meta.json");
    }
  require_writable({{options.output}}, inputs);
  const RunFolder folder{fs::path(options.output).parent_path()};
  if (const auto writer = writer_of(folder))
    throw InvalidInput(
        "{}: a run is writing into its folder: {}; wait until it has finished, or give another output",
        options.output, *writer);
}

void fit_command(const FitCommandOptions& options, Context& context) {
  if (options.require_all && options.choices.allow_missing > 0)
    throw UsageError("give --require-all or --allow-missing, not both");
  const bool in_memory = context.called && !context.called->input.is_null();
  const Campaign campaign = campaign_of_part(in_memory ? campaign_of(context.called->input, options.campaign)
                                                       : read_campaign(campaign_file(options.campaign)),
                                             options.part);
  FitChoices choices = options.choices;
  if (!context.called) {
    check_output(campaign, options);
    choices.result = options.output;
  }
  const FittedCampaign fitted = fit_campaign(campaign, choices, context);
  if (context.called)
    context.called->object = fitted.json;
  else
    write_fit(options.output, campaign, fitted);
  if (!is_standard_output(options.output) && !context.called)
    print_text(options.json ? text_of(fitted.json) : parameter_table(fitted.json) + slide_table(fitted.json));
  const std::string where = context.called ? "" : " in " + options.output;
  report_fit(campaign, fitted, options.explain, "identifiability and next_experiment" + where, context);
}

}  // namespace

void add_fit(CLI::App& app, Context& context) {
  auto options = std::make_shared<FitCommandOptions>();
  CLI::App& command = *app.add_subcommand("fit", "Fit mu1, mu2 and the phase lag to the runs of a campaign");
  add_option(command, "CAMPAIGN", options->campaign, "CAMPAIGN.toml", "The campaign file")->required();
  add_option(command, "-o,--output", options->output, "fit.json", "The result")->required(!context.called);
  add_option(
      command, "--tracks", options->choices.tracks, "DIR",
      "Folder with the runs' tracks, NAME.csv (DIR/tracks of `run`); without it the videos are tracked now");
  add_option(command, "--part", options->part, "NAME", "Which of the campaign's several [[part]]");
  add_option(command, "--measurements", options->choices.measurements, "DIR",
             "Also write what was measured in each run's track, NAME.json (DIR/measurements of `run`)");
  command.add_flag("--require-all", options->require_all, "Every run must be usable (the default)");
  add_option(command, "--allow-missing", options->choices.allow_missing, "N",
             "Go on when up to N runs are not usable")
      ->check(whole_number(0));
  add_option(command, "--bootstrap", options->choices.fit.bootstrap, "N",
             "Also intervals by refitting N simulated campaigns (400 give their ends to about 10 %)")
      ->check(whole_number(20, 1'000'000));
  add_option(command, "--seed", options->choices.fit.bootstrap_seed, "N",
             "Seed of the bootstrap; recorded in the result");
  add_option(command, "--loss", options->choices.loss, "LOSS",
             "squares (default) or huber: outlying displacements are down-weighted; what that means for the "
             "intervals is printed with them")
      ->check(one_of(losses()));
  command.add_flag("--compare-models", options->choices.fit.rivals,
                   "Refit under each explanation (tilt, laws of friction, ...) even where the residuals give "
                   "no reason to");
  command.add_flag("--json", options->json, "Print the result as one JSON object");
  command.add_flag("--explain", options->explain,
                   "Print the whole report: residuals, correlations, what was left out");
  add_common(command, context,
             std::string("  tribotrack fit campaign.toml -o fit.json\n  tribotrack fit campaign.toml "
                         "--tracks out/tracks -o fit.json --json") +
                 kOfSds);
  command.callback([options, &context] { fit_command(*options, context); });
}

// tribotrack report: the page of a folder that `run` has filled.

namespace {

/// Runs the script as Debian's python3 does, with nothing of the user's settings, of the current folder or of
/// the script's own: a json.py or matplotlibrc that lies there is not what it reads. What it says; its
/// status, 127 where there is no python3.
std::string run_script(const std::string& script, int& status) {
  std::string quoted;
  for (const char c : script) quoted += c == '\'' ? std::string("'\\''") : std::string{c};
  const std::string command = fmt::format(
      "d=$(mktemp -d) && cd \"$d\" && env -i HOME=\"$d\" MPLCONFIGDIR=\"$d\" LC_ALL=C.UTF-8 /usr/bin/python3 "
      "-I -B '{}' 2>&1; s=$?; rm -rf \"$d\"; exit $s",
      quoted);
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) throw InvalidInput("/usr/bin/python3 cannot be started");
  std::string said;
  for (int c; (c = std::fgetc(pipe)) != EOF;) said += static_cast<char>(c);
  const int ended = ::pclose(pipe);
  status = WIFEXITED(ended) ? WEXITSTATUS(ended) : 1;
  return said;
}

/// The last line that says something.
std::string last_line(const std::string& text) {
  const auto end = text.find_last_not_of(" \n");
  if (end == std::string::npos) return "the plotting program failed";
  const auto begin = text.rfind('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
}

/// Writes table and script, figures.py and runs.csv, and runs the script: each figure as NAME-84mm and
/// NAME-174mm, .svg and .pdf, the widths of one and of two columns of a journal, but for figures that have no
/// runs to show. Throws InvalidInput with
/// what to install where there is no python3 with matplotlib; table and script are then there all the same.
void print_figures(const std::filesystem::path& folder, std::string_view runs_csv, std::string_view script) {
  create_folder(folder);
  const std::string path = std::filesystem::absolute(folder / "figures.py").string();
  write_file(path, script);
  write_file(folder / "runs.csv", runs_csv);
  int status = 0;
  const std::string said = run_script(path, status);
  if (status == 0) return;
  const bool missing = status == 127 || said.find("ModuleNotFoundError") != std::string::npos;
  throw InvalidInput(
      "{}: the figures were not drawn: {}; {} (table and script are there)", folder.string(), last_line(said),
      missing ? fmt::format("install Debian's python3-matplotlib, then `python3 {}` draws them", path)
              : fmt::format("`python3 {}` says more", path));
}

}  // namespace

void add_report(CLI::App& app, Context& context) {
  auto folder = std::make_shared<std::string>();
  auto output = std::make_shared<std::string>();
  auto figures = std::make_shared<std::string>();
  auto tables = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  CLI::App& command =
      *app.add_subcommand("report", "One self-contained HTML page from the folder of a `run`");
  command.add_option("DIR", *folder, "Folder that `tribotrack run` has filled")->required();
  add_option(command, "-o,--output", *output, "report.html",
             "The page; it is self-contained and loads nothing from elsewhere");
  add_option(command, "--figures", *figures, "DIR",
             "Folder for alpha and v against phi and dtau and for the residuals as SVG and PDF, 84 and 174 "
             "mm wide, drawn by matplotlib (Debian's python3-matplotlib), with runs.csv and the script that "
             "drew them from it");
  add_option(command, "--tables", *tables, "DIR",
             "Folder for runs.csv, parameters.csv and report.txt (DIR itself: where `run` has them)");
  command.add_flag("--json", *json, "Print what was written as one JSON object");
  add_common(command, context,
             "  tribotrack report out -o report.html\n  tribotrack report out --figures figures");
  command.callback([folder, output, figures, tables, json, &context] {
    const RunFolder run_folder{*folder};
    if (output->empty() && figures->empty() && tables->empty())
      throw CLI::RequiredError("--output report.html, --figures DIR or --tables DIR");
    std::vector<Output> outputs;
    if (!output->empty()) outputs.push_back({*output});
    if (!tables->empty()) {
      create_folder(*tables);
      const RunFolder to{*tables};
      for (const auto& file : {to.runs_table(), to.parameter_table(), to.text()}) outputs.push_back({file});
    }
    require_writable(outputs, run_folder.files_of_report());
    if (const auto writer = writer_of(run_folder))
      say(context.quiet,
          fmt::format("note: {} is being written by {}: the page shows what is there now", *folder, *writer));
    const Report report = report_of(run_folder);
    for (const std::string& file : report.missing) say(context.quiet, "warning: " + file);
    if (!output->empty()) {
      write_file(*output, report.page);
      say(context.quiet, *output + ": written");
    }
    if (!tables->empty()) {
      const RunFolder to{*tables};
      write_file(to.runs_table(), report.runs_csv);
      write_file(to.parameter_table(), report.parameters_csv);
      write_file(to.text(), report.text);
      say(context.quiet, fmt::format("{}: runs.csv, parameters.csv, report.txt written", *tables));
    }
    if (!figures->empty()) {
      create_folder(*figures);
      require_writable({{fs::path(*figures) / "runs.csv"}}, run_folder.files_of_report());
      print_figures(*figures, report.runs_csv, embedded_assets().figures_py);
      say(context.quiet, *figures + ": figures written");
    }
    if (!*json) return;
    print_text(text_of(Json{{"page", output->empty() ? Json() : Json(*output)},
                            {"figures_folder", figures->empty() ? Json() : Json(*figures)},
                            {"figures", report.figures},
                            {"tables_folder", tables->empty() ? Json() : Json(*tables)},
                            {"missing", report.missing}}));
  });
}

// tribotrack verify: do the results in a folder belong together?

void add_verify(CLI::App& app, Context& context) {
  auto folder = std::make_shared<std::string>();
  CLI::App& command = *app.add_subcommand(
      "verify",
      "Check that report, fit, tracks and recordings belong together; exit 3 names what does not match");
  command.add_option("DIR", *folder, "Folder that `tribotrack run` has filled")->required();
  add_common(command, context, "  tribotrack verify out");
  command.callback([folder] { print("{}: all {} files are those of its run\n", *folder, verify(*folder)); });
}

}  // namespace tribotrack::apps
