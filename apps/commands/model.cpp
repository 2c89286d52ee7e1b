// tribotrack simulate: one trajectory of the friction model.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <utility>

#include "apps/commands/command.h"
#include "apps/files/run_folder.h"
#include "apps/files/scenario_file.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/simulating/simulation.h"
#include "apps/simulating/sweep.h"
#include "apps/text/number_text.h"
#include "apps/text/output_file.h"
#include "model/plan.h"
#include "model/trajectory.h"

namespace tribotrack::apps {

namespace {

struct SimulateOptions {
  std::string scenario;
  std::string output;
  std::string start;
  bool json = false;
  bool explain = false;
  std::optional<double> samples_per_cycle;
  // name in scenario_parameter_names() -> value from the command line
  std::vector<std::pair<std::string, std::optional<double>>> values = {{"mu1", {}},
                                                                       {"mu2", {}},
                                                                       {"mu1_over_mu2", {}},
                                                                       {"amplitude_mm", {}},
                                                                       {"amplitude_y_mm", {}},
                                                                       {"omega_rad_s", {}},
                                                                       {"epsilon_rad", {}},
                                                                       {"phi_rad", {}},
                                                                       {"dtau_rad", {}},
                                                                       {"lag_rad", {}},
                                                                       {"gravity_m_s2", {}},
                                                                       {"tilt_x_rad", {}},
                                                                       {"tilt_y_rad", {}},
                                                                       {"cycles", {}},
                                                                       {"start_phase_rad", {}},
                                                                       {"velocity_x_mm_s", {}},
                                                                       {"velocity_y_mm_s", {}}};
};

std::string help_for(const std::string& name) {
  if (name == "mu1") return "Nominal friction coefficient mu1";
  if (name == "mu2") return "Reduced friction coefficient mu2, inside the pulse";
  if (name == "mu1_over_mu2") return "Give mu2 as this ratio mu1/mu2 instead";
  if (name == "amplitude_mm") return "Platform amplitude A (and A_y)";
  if (name == "amplitude_y_mm") return "Platform amplitude along y, if different";
  if (name == "omega_rad_s") return "Angular frequency w of the platform";
  if (name == "epsilon_rad")
    return "Phase shift epsilon between the axes (pi/2: a circle, clockwise with y up)";
  if (name == "phi_rad") return "Phase phi at which the pulse of reduced friction opens";
  if (name == "dtau_rad") return "Width dtau of the pulse, 0 .. 2pi";
  if (name == "lag_rad") return "Phase lag of the actuator, added to phi";
  if (name == "gravity_m_s2") return "Gravity g";
  if (name == "tilt_x_rad") return "Slope of the platform towards +x (right)";
  if (name == "tilt_y_rad") return "Slope of the platform towards +y (up)";
  if (name == "cycles") return "Platform cycles to simulate";
  if (name == "start_phase_rad") return "Platform phase wt at the start";
  return "Initial velocity relative to the platform (start = rest)";
}

/// " (default 0.28)": what holds without a scenario, the paper's conditions.
std::string default_of(const std::string& name) {
  if (name == "epsilon_rad") return " (default pi/2)";
  const Json conditions = json_of(model::Scenario());
  return conditions.contains(name) && name != "amplitude_y_mm"
             ? fmt::format(" (default {:.10g})", conditions[name].get<double>())
             : "";
}

/// With the name that campaigns have for it, where that differs.
std::string flag_of(std::string name) {
  const std::string of_campaign = name == "omega_rad_s"   ? ",--angular-frequency-rad-s"
                                  : name == "epsilon_rad" ? ",--phase-shift-rad"
                                  : name == "lag_rad"     ? ",--phase-lag-rad"
                                                          : "";
  for (char& c : name)
    if (c == '_') c = '-';
  return "--" + name + of_campaign;
}

GivenScenario given_of(const SimulateOptions& options) {
  GivenScenario given{options.scenario, {}, options.start, options.samples_per_cycle};
  for (const auto& [name, value] : options.values)
    if (value) given.values.emplace_back(name, *value);
  return given;
}

std::string table_of(const model::Trajectory& trajectory, int samples_per_cycle) {
  std::string table = "time_s,x_mm,y_mm,vx_mm_s,vy_mm_s,mu,state\n";
  for_each_row(trajectory, samples_per_cycle, [&](const SimulatedRow& row) {
    table += fmt::format("{},{},{},{},{},{},{}\n", row.time_s, row.x_mm, row.y_mm, row.vx_mm_s, row.vy_mm_s,
                         row.mu, row.state);
  });
  return table;
}

void check_output(const SimulateOptions& options) {
  if (options.output.empty()) return;
  if (is_standard_output(options.output)) {
    if (options.json) throw UsageError("give -o - or --json: both would go to standard output");
    return;
  }
  std::vector<std::filesystem::path> inputs;
  if (!options.scenario.empty()) inputs.emplace_back(options.scenario);
  require_writable({{options.output}}, inputs);
}

void simulate(const SimulateOptions& options, const Context& context) {
  const ScenarioFile file = scenario_of(given_of(options));
  check_output(options);
  if (!options.output.empty()) require_sensible_table(options.output, file.scenario, file.samples_per_cycle);
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
  if (!options.output.empty()) {
    MetaFile meta;
    meta.command = "simulate";
    if (!options.scenario.empty()) meta.inputs = {hashed_input(options.scenario)};
    meta.configuration = json_of(file.scenario);
    meta.configuration["samples_per_cycle"] = file.samples_per_cycle;
    meta.more["results"] = results;
    meta.more["plan"] = Json::array();
    for (const auto& stage : model::plan(file.scenario))
      meta.more["plan"].push_back({{"stage", stage.name},
                                   {"on", stage.on},
                                   {"reason", stage.reason},
                                   {"error_bound_m", stage.error_bound}});
    write_result(options.output, table_of(trajectory, file.samples_per_cycle), meta);
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
      "SCENARIO", options->scenario,
      "Scenario file (TOML); the flags override it. Without one: the paper's platform (A, w, epsilon, g) and "
      "the defaults below, in which friction is constant: mu2 and dtau make pulses");
  for (auto& [name, value] : options->values) {
    if (name.ends_with("_rad"))
      add_angle(command, flag_of(name), value, help_for(name) + default_of(name));
    else
      add_number(command, flag_of(name), value, help_for(name) + default_of(name));
  }
  command
      .add_option("--start", options->start,
                  "How it starts: at rest, circling at constant mu1 until the first pulse, or in the steady "
                  "motion (default rest)")
      ->type_name("rest|circling|steady");
  add_number(command, "--samples-per-cycle", options->samples_per_cycle,
             "Rows of the table per cycle (default 100)");
  command
      .add_option("-o,--output", options->output,
                  "Write the trajectory: time_s,x_mm,y_mm,vx_mm_s,vy_mm_s,mu,state")
      ->type_name("T.csv");
  command.add_flag("--json", options->json, "Print the results as one JSON object");
  command.add_flag("--explain", options->explain, "Print which stages this scene needs and what is left out");
  add_common(command, context,
             "  tribotrack simulate --mu1 0.1 --mu2 0.0125 --amplitude-mm 0.28 --omega-rad-s 62.8 \\\n"
             "      --phi-rad pi/2 --dtau-rad pi/3 --cycles 20 -o trajectory.csv");
  command.callback([options, &context] { simulate(*options, context); });
}

// tribotrack sweep: alpha and v over one or two parameters.

namespace {

/// One list for each column of the table; null for "no value".
Json columns_of(const Sweep& sweep, const SweptModel& solved) {
  Json json;
  for (std::size_t index = 0; index < sweep.count(); ++index)
    for (std::size_t axis = 0; axis < sweep.axes().size(); ++axis)
      json[sweep.axes()[axis].name()].push_back(sweep.value(index, axis));
  for (const auto& [name, column] :
       {std::pair{"alpha_rad", &solved.alpha_rad}, std::pair{"v_mm_s", &solved.v_mm_s},
        std::pair{"steady_alpha_rad", &solved.steady_alpha_rad},
        std::pair{"steady_v_mm_s", &solved.steady_v_mm_s}})
    for (const double value : *column) json[name].push_back(finite_json(value));
  return json;
}

struct SweepOptions {
  bool json = false;
  std::string scenario;
  std::vector<std::string> over;
  std::string output;
};

void run_sweep(const SweepOptions& options, const Context& context) {
  const ScenarioFile base = options.scenario.empty() ? ScenarioFile{} : read_scenario_file(options.scenario);
  const auto& texts = options.over.empty() ? base.over : options.over;
  const Sweep sweep(base, sweep_axes(texts));
  if (is_standard_output(options.output)) {
    if (options.json) throw UsageError("give -o - or --json: both would go to standard output");
  } else {
    std::vector<std::filesystem::path> inputs;
    if (!options.scenario.empty()) inputs.emplace_back(options.scenario);
    require_writable({{options.output}}, inputs);
  }

  const SweptModel solved = solve(sweep, context);
  if (options.json) print_text(text_of(columns_of(sweep, solved)));
  std::string table;
  for (const SweepAxis& axis : sweep.axes()) table += axis.name() + ",";
  table += "alpha_rad,v_mm_s,steady_alpha_rad,steady_v_mm_s\n";
  for (std::size_t index = 0; index < sweep.count(); ++index) {
    for (std::size_t axis = 0; axis < sweep.axes().size(); ++axis)
      table += compact(sweep.value(index, axis)) + ",";
    table += fmt::format("{},{},{},{}\n", compact(solved.alpha_rad[index]), compact(solved.v_mm_s[index]),
                         compact(solved.steady_alpha_rad[index]), compact(solved.steady_v_mm_s[index]));
  }
  MetaFile meta;
  meta.command = "sweep";
  if (!options.scenario.empty()) meta.inputs = {hashed_input(options.scenario)};
  meta.configuration = json_of(base.scenario);
  meta.configuration["over"] = texts;
  write_result(options.output, table, meta);
  say(context.quiet,
      fmt::format("{}: {} scenarios; {}", options.output, sweep.count(), solved.summary.full_report()));
}

}  // namespace

void add_sweep(CLI::App& app, Context& context) {
  auto options = std::make_shared<SweepOptions>();
  CLI::App& command = *app.add_subcommand("sweep", "alpha and v of the model over one or two parameters");
  command.add_option("SCENARIO", options->scenario,
                     "Scenario file (TOML). Without one: the paper's conditions");
  command
      .add_option("--over", options->over,
                  "NAME=FROM:TO:COUNT or NAME=VALUE,VALUE,..., once or twice; names: " +
                      fmt::format("{}", fmt::join(scenario_parameter_names(), ", ")))
      ->type_name("AXIS");
  command
      .add_option("-o,--output", options->output,
                  "Write the table: swept names, alpha_rad, v_mm_s and those of the steady motion")
      ->type_name("S.csv")
      ->required();
  command.add_flag("--json", options->json, "Print the table as one JSON object, a list for each column");
  add_common(command, context,
             "  tribotrack sweep data/figure7a.toml --over phi_rad=0:2pi:73 --over dtau_rad=pi/6:pi:6 -o "
             "sweep.csv");
  command.callback([options, &context] { run_sweep(*options, context); });
}

}  // namespace tribotrack::apps
