// tribotrack simulate: one trajectory of the friction model.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "apps/commands/command.h"
#include "apps/files/run_folder.h"
#include "apps/files/scenario_file.h"
#include "apps/program/called.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/simulating/simulation.h"
#include "apps/simulating/sweep.h"
#include "apps/text/csv_table.h"
#include "apps/text/output_file.h"
#include "model/plan.h"
#include "model/trajectory.h"

namespace tribotrack::apps {

namespace {

struct SimulateOptions {
  GivenScenario given;
  std::string output;
  bool json = false, explain = false;
};

/// " (default 0.28)": what holds without a scenario, the paper's conditions.
std::string default_text(const Key<ScenarioFile>& parameter) {
  if (parameter.name == "epsilon_rad") return " (default pi/2)";
  const auto value = default_of(parameter);
  return value ? fmt::format(" (default {:.10g})", *value) : "";
}

/// A flag for each parameter. Names in another unit are flags of their own.
void add_parameters(CLI::App& command, GivenScenario& given) {
  const auto add = [&](const std::string& flags, const std::string& name, const std::string& help) {
    auto& value = given.values.emplace_back(name, std::nullopt).second;
    name.ends_with("_rad") ? add_angle(command, flags, value, help) : add_number(command, flags, value, help);
  };
  for (const Key<ScenarioFile>& parameter : scenario_parameters()) {
    std::string flags = flag_of(parameter.name);
    for (const OtherName& other : other_names(parameter.name))
      if (other.factor == 1) flags += "," + flag_of(other.name);
    add(flags, parameter.name, parameter.meaning + default_text(parameter));
    for (const OtherName& other : other_names(parameter.name))
      if (other.factor != 1) add(flag_of(other.name), other.name, "The same by another unit");
  }
  add_option(command, "--start", given.start, "rest|circling|steady",
             "How it starts: at rest, circling at constant mu1 until the first pulse, or in the steady "
             "motion (default rest)");
}

void simulate(const SimulateOptions& options, const Context& context) {
  const ScenarioFile file = scenario_of(options.given);
  check_output(options.output, options.json, {options.given.file});
  if (!options.output.empty() || context.called)
    require_sensible_table(context.called ? "simulate" : options.output, file.scenario,
                           file.samples_per_cycle);
  if (const model::Friction& friction = file.scenario.friction; friction.reduced > friction.nominal)
    say(context.quiet, fmt::format("note: mu2 = {} within the pulse is more than mu1 = {} outside of it",
                                   friction.reduced, friction.nominal));
  if (options.explain)
    for (const auto& stage : model::plan(file.scenario))
      print_error(
          fmt::format("{:<20} {:<4} {}{}", stage.name, stage.on ? "on" : "off", stage.reason,
                      stage.on ? "" : fmt::format("; error at most {:.2g} mm", 1e3 * stage.error_bound)));

  const model::Trajectory trajectory = model::integrate(file.scenario);
  const Json results = simulation_json(trajectory);
  if (context.called) {
    context.tell("simulate", 1, 1);
    context.called->columns = columns_of(trajectory, file.samples_per_cycle);
    context.called->object = results;
    return;
  }
  if (!options.output.empty()) {
    MetaFile meta;
    meta.command = "simulate";
    if (!options.given.file.empty()) meta.inputs = {hashed_input(options.given.file)};
    meta.configuration = json_of(file.scenario);
    meta.configuration["samples_per_cycle"] = file.samples_per_cycle;
    meta.more["results"] = results;
    meta.more["plan"] = Json::array();
    for (const auto& stage : model::plan(file.scenario))
      meta.more["plan"].push_back({{"stage", stage.name},
                                   {"on", stage.on},
                                   {"reason", stage.reason},
                                   {"error_bound_m", stage.error_bound}});
    write_result(options.output, csv_of(columns_of(trajectory, file.samples_per_cycle)), meta);
  }
  if (options.json) {
    print_text(text_of(results));
  } else if (!is_standard_output(options.output)) {
    for (const auto& [name, value] : results.items()) print("{:<18} {}\n", name, value.dump());
    say(context.quiet, trajectory.summary().brief_report());
  }
}

}  // namespace

void add_simulate(CLI::App& app, Context& context) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App& command = *app.add_subcommand("simulate", "Simulate one trajectory of the friction model");
  command.add_option(
      "SCENARIO", options->given.file,
      "Scenario file (TOML); the flags override it. Without one: the paper's platform (A, w, epsilon, g) and "
      "the defaults below, in which friction is constant: mu2 and dtau make pulses");
  add_parameters(command, options->given);
  add_number(command, "--samples-per-cycle", options->given.samples_per_cycle,
             "Rows of the table per cycle (default 100)");
  add_option(command, "-o,--output", options->output, "T.csv",
             "Write the trajectory: time_s,x_mm,y_mm,vx_mm_s,vy_mm_s,mu,state");
  command.add_flag("--json", options->json, "Print the results as one JSON object");
  command.add_flag("--explain", options->explain, "Print which stages this scene needs and what is left out");
  add_common(command, context,
             "  tribotrack simulate --mu1 0.1 --mu2 0.0125 --amplitude-mm 0.28 --omega-rad-s 62.8 \\\n"
             "      --phi-rad pi/2 --dtau-rad pi/3 --cycles 20 -o trajectory.csv");
  command.callback([options, &context] { simulate(*options, context); });
}

// tribotrack sweep: alpha and v over one or two parameters.

namespace {

struct SweepOptions {
  GivenScenario given;
  std::string output;
  std::vector<std::string> over;
  bool json = false;
};

/// A column for each axis, of its value in every scenario or, `alone`, of its values, then what was solved.
Columns columns_of(const Sweep& sweep, SweptModel solved, bool alone) {
  Columns columns;
  for (std::size_t axis = 0; axis < sweep.axes().size(); ++axis) {
    const SweepAxis& swept = sweep.axes()[axis];
    std::vector<double> values;
    for (std::size_t k = 0; k < (alone ? swept.count() : sweep.count()); ++k)
      values.push_back(alone ? swept.value(k) : sweep.value(k, axis));
    columns.emplace_back(swept.name(), std::move(values));
  }
  columns.emplace_back("alpha_rad", std::move(solved.alpha_rad));
  columns.emplace_back("v_mm_s", std::move(solved.v_mm_s));
  columns.emplace_back("steady_alpha_rad", std::move(solved.steady_alpha_rad));
  columns.emplace_back("steady_v_mm_s", std::move(solved.steady_v_mm_s));
  return columns;
}

/// One list for each column of the table; null for "no value".
Json lists_of(const Columns& columns) {
  Json json;
  for (const auto& [name, column] : columns)
    for (const double value : std::get<std::vector<double>>(column)) json[name].push_back(finite_json(value));
  return json;
}

void run_sweep(const SweepOptions& options, const Context& context) {
  const ScenarioFile base = base_of(options.given);
  const auto& texts = options.over.empty() ? base.over : options.over;
  const Sweep sweep(base, sweep_axes(texts));
  check_output(options.output, options.json, {options.given.file});
  SweptModel solved = solve(sweep, context);
  const auto none = std::ranges::count_if(solved.steady_v_mm_s, [](double v) { return std::isnan(v); });
  Columns columns = columns_of(sweep, std::move(solved), context.called != nullptr);
  if (context.called) {
    context.called->columns = std::move(columns);
    return;
  }
  if (options.json) print_text(text_of(lists_of(columns)));
  MetaFile meta;
  meta.command = "sweep";
  if (!options.given.file.empty()) meta.inputs = {hashed_input(options.given.file)};
  meta.configuration = json_of(base.scenario);
  meta.configuration["over"] = texts;
  write_result(options.output, csv_of(columns, compact), meta);
  say(context.quiet,
      fmt::format("{}: {} scenarios, {} without a steady motion", options.output, sweep.count(), none));
}

}  // namespace

void add_sweep(CLI::App& app, Context& context) {
  auto options = std::make_shared<SweepOptions>();
  CLI::App& command = *app.add_subcommand("sweep", "alpha and v of the model over one or two parameters");
  command.add_option("SCENARIO", options->given.file,
                     "Scenario file (TOML); the flags override it. Without one: the paper's conditions");
  add_option(command, "--over", options->over, "AXIS",
             "NAME=FROM:TO:COUNT or NAME=VALUE,VALUE,..., once or twice; names: " +
                 fmt::format("{}", fmt::join(scenario_parameter_names(), ", ")));
  add_parameters(command, options->given);
  add_option(command, "-o,--output", options->output, "S.csv",
             "Write the table: swept names, alpha_rad, v_mm_s and those of the steady motion")
      ->required(!context.called);
  command.add_flag("--json", options->json, "Print the table as one JSON object, a list for each column");
  add_common(
      command, context,
      "  tribotrack sweep data/figure7a.toml --over phi_rad=0:2pi:73 --over dtau_rad=pi/6:pi:6 -o sweep.csv");
  command.callback([options, &context] { run_sweep(*options, context); });
}

}  // namespace tribotrack::apps
