// tribotrack simulate: one trajectory of the friction model.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/commands/command.h"
#include "apps/files/meta_file.h"
#include "apps/files/scenario_file.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/number_text.h"
#include "apps/text/output_file.h"
#include "model/alpha_v.h"
#include "model/plan.h"
#include "model/steady_orbit.h"
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

std::string flag_of(std::string name) {
  for (char& c : name)
    if (c == '_') c = '-';
  return "--" + name;
}

ScenarioFile scenario_of(const SimulateOptions& options) {
  const auto is_given = [&](const char* name) {
    return std::any_of(options.values.begin(), options.values.end(),
                       [&](const auto& entry) { return entry.first == name && entry.second; });
  };
  if (is_given("mu2") && is_given("mu1_over_mu2"))
    throw UsageError("--mu2 and --mu1-over-mu2 mean the same; give one of them");
  ScenarioFile file = options.scenario.empty() ? ScenarioFile{} : read_scenario_file(options.scenario);
  for (const auto& [name, value] : options.values)
    if (value) set_scenario_parameter(file, name, *value);
  if (!options.start.empty()) file.scenario.start = parse_start(options.start);
  if (options.samples_per_cycle) {
    if (!(*options.samples_per_cycle >= 1 && *options.samples_per_cycle <= 1e6))
      throw UsageError("--samples-per-cycle must be between 1 and 1000000");
    file.samples_per_cycle = static_cast<int>(*options.samples_per_cycle);
  }
  file.settle();
  file.scenario.validate();
  return file;
}

double rows_of(const model::Scenario& scenario, int samples_per_cycle) {
  return std::ceil(scenario.cycles * samples_per_cycle);
}

/// Before the work: a table may grow beyond any disk.
void require_sensible_table(const SimulateOptions& options, const ScenarioFile& file) {
  constexpr double kBytesPerRow = 120, kLargest = 2e9;
  const double rows = rows_of(file.scenario, file.samples_per_cycle) + 1;
  if (options.output.empty() || rows * kBytesPerRow < kLargest) return;
  throw InvalidInput(
      fmt::format("{}: the table would have {:.0f} rows and take about {:.3g} GB, of at most {:.0f} GB: "
                  "lower --cycles or --samples-per-cycle",
                  options.output, rows, 1e-9 * rows * kBytesPerRow, 1e-9 * kLargest));
}

std::string table_of(const model::Trajectory& trajectory, int samples_per_cycle) {
  const auto& scenario = trajectory.scenario();
  const auto count = static_cast<long>(rows_of(scenario, samples_per_cycle));
  std::string table = "time_s,x_mm,y_mm,vx_mm_s,vy_mm_s,mu,state\n";
  for (long k = 0; k <= count; ++k) {
    const double time = k == count
                            ? trajectory.end_time()
                            : trajectory.end_time() * static_cast<double>(k) / static_cast<double>(count);
    const model::Sample s = trajectory.at(time);
    table += fmt::format("{},{},{},{},{},{},{}\n", s.time, s.position.x() * 1e3, s.position.y() * 1e3,
                         s.velocity.x() * 1e3, s.velocity.y() * 1e3, s.mu,
                         s.state == model::State::slip ? "slip" : "stick");
  }
  return table;
}

Json results_of(const model::Trajectory& trajectory) {
  const auto& scenario = trajectory.scenario();
  const model::Sample end = trajectory.end();
  Json json;
  json["end_x_mm"] = end.position.x() * 1e3;
  json["end_y_mm"] = end.position.y() * 1e3;
  const bool moved = end.position.norm() > 0;
  json["alpha_rad"] = moved ? Json(model::displacement_angle(end.position)) : Json();
  json["v_mm_s"] = model::mean_velocity(end.position, trajectory.end_time()) * 1e3;
  json["cycles"] = scenario.cycles;
  json["stops"] = trajectory.summary().stops;
  json["sticking_fraction"] = trajectory.summary().sticking_fraction;
  json["steps"] = trajectory.summary().steps;
  json["steady"] = Json();
  if (const auto orbit = model::steady_orbit(scenario); orbit && scenario.cycles > 0) {
    constexpr double kRounding = 1e-12;  // of the platform's velocity
    double v = orbit->mean_velocity(scenario.drive.angular_frequency);
    if (v < kRounding * scenario.drive.amplitude * scenario.drive.angular_frequency) v = 0;
    json["steady"] = {{"alpha_rad", v > 0 ? Json(orbit->alpha()) : Json()}, {"v_mm_s", v * 1e3}};
  }
  return json;
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
  const ScenarioFile file = scenario_of(options);
  check_output(options);
  require_sensible_table(options, file);
  if (const model::Friction& friction = file.scenario.friction; friction.reduced > friction.nominal)
    say(context.quiet, fmt::format("note: mu2 = {} within the pulse is more than mu1 = {} outside of it",
                                   friction.reduced, friction.nominal));
  if (options.explain)
    for (const auto& stage : model::plan(file.scenario))
      print_error(fmt::format("{:<20} {:<4} {}{}", stage.name, stage.on ? "on" : "off", stage.reason,
                              stage.on ? ""
                                       : fmt::format("; saves {:.0f} %, error at most {:.2g} mm",
                                                     100 * stage.predicted_saving, 1e3 * stage.error_bound)));

  const model::Trajectory trajectory = model::integrate(file.scenario);
  const Json results = results_of(trajectory);
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
                                   {"predicted_saving", stage.predicted_saving},
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

}  // namespace tribotrack::apps
