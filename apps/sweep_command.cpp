// tribotrack sweep: alpha and v over one or two parameters.
#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <thread>

#include "apps/angle.h"
#include "apps/command.h"
#include "apps/meta_file.h"
#include "apps/number_text.h"
#include "apps/output_file.h"
#include "apps/parallel.h"
#include "apps/progress.h"
#include "apps/scenario_file.h"
#include "model/displacement_angle.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::apps {

namespace {

struct Axis {
  std::string name;
  double from = 0, to = 0;
  long count = 0;
  double value(long k) const {
    return count == 1 ? from : from + (to - from) * static_cast<double>(k) / static_cast<double>(count - 1);
  }
};

Axis parse_axis(const std::string& text) {
  const auto refuse = [&] {
    throw UsageError(fmt::format("--over {}: must read NAME=FROM:TO:COUNT, such as phi_rad=0:2pi:73", text));
  };
  const auto equals = text.find('=');
  const auto first = text.find(':', equals == std::string::npos ? 0 : equals);
  const auto second = first == std::string::npos ? first : text.find(':', first + 1);
  if (equals == std::string::npos || second == std::string::npos) refuse();
  Axis axis;
  axis.name = text.substr(0, equals);
  const auto from = parse_angle(text.substr(equals + 1, first - equals - 1));
  const auto to = parse_angle(text.substr(first + 1, second - first - 1));
  const auto count = parse_number(text.substr(second + 1));
  if (!from || !to || !count || *count < 1 || *count > 1e8 || *count != std::floor(*count)) refuse();
  axis.from = *from;
  axis.to = *to;
  axis.count = static_cast<long>(*count);
  return axis;
}

struct Row {
  std::optional<double> alpha, v, steady_alpha, steady_v;
};

Row solve(const model::Scenario& scenario) {
  Row row;
  model::IntegrationOptions end_only;
  end_only.dense = false;
  const model::Trajectory trajectory = model::integrate(scenario, end_only);
  const Eigen::Vector2d end = trajectory.end().position;
  row.v = model::mean_velocity(end, trajectory.end_time()) * 1e3;
  if (end.norm() > 0) row.alpha = model::displacement_angle(end);
  if (const auto orbit = model::steady_orbit(scenario)) {
    row.steady_v = orbit->mean_velocity(scenario.drive.angular_frequency) * 1e3;
    if (*row.steady_v > 0) row.steady_alpha = orbit->alpha();
  }
  return row;
}

struct SweepOptions {
  std::string scenario;
  std::vector<std::string> over;
  std::string output;
};

void sweep(const SweepOptions& options, const Context& context) {
  const ScenarioFile base = options.scenario.empty() ? ScenarioFile{} : read_scenario_file(options.scenario);
  const auto& texts = options.over.empty() ? base.over : options.over;
  if (texts.empty() || texts.size() > 2)
    throw UsageError(
        "sweep needs one or two --over NAME=FROM:TO:COUNT (or `over` in [sweep] of the scenario)");
  std::vector<Axis> axes;
  for (const auto& text : texts) axes.push_back(parse_axis(text));
  require_writable(options.output);

  const long inner = axes.size() == 2 ? axes[1].count : 1;
  const long total = axes[0].count * inner;
  const auto scenario_at = [&](long index) {
    ScenarioFile file = base;
    set_scenario_parameter(file, axes[0].name, axes[0].value(index / inner));
    if (axes.size() == 2) set_scenario_parameter(file, axes[1].name, axes[1].value(index % inner));
    file.settle();
    return file.scenario;
  };
  for (long index = 0; index < total; ++index)
    scenario_at(index).validate();  // refuse before the work, not after it

  std::vector<Row> rows(static_cast<std::size_t>(total));
  {
    Progress progress("sweep", context.quiet);
    std::atomic<long> done = 0;
    for_each_index(total, threads_to_use(context), [&](long index) {
      rows[static_cast<std::size_t>(index)] = solve(scenario_at(index));
      progress.update(++done, total);
    });
  }

  std::string table;
  for (const Axis& axis : axes) table += axis.name + ",";
  table += "alpha_rad,v_mm_s,steady_alpha_rad,steady_v_mm_s\n";
  for (long index = 0; index < total; ++index) {
    table += compact(axes[0].value(index / inner)) + ",";
    if (axes.size() == 2) table += compact(axes[1].value(index % inner)) + ",";
    const Row& row = rows[static_cast<std::size_t>(index)];
    table += fmt::format("{},{},{},{}\n", compact(row.alpha), compact(row.v), compact(row.steady_alpha),
                         compact(row.steady_v));
  }
  MetaFile meta;
  meta.command = "sweep";
  if (!options.scenario.empty()) meta.inputs = {options.scenario};
  meta.configuration = json_of(base.scenario);
  meta.configuration["over"] = texts;
  write_file(options.output, table);
  meta.write_beside(options.output);
  say(context.quiet, fmt::format("{}: {} scenarios", options.output, total));
}

}  // namespace

void add_sweep(CLI::App& app, Context& context) {
  auto options = std::make_shared<SweepOptions>();
  CLI::App& command = *app.add_subcommand("sweep", "alpha and v of the model over one or two parameters");
  command.add_option("SCENARIO", options->scenario,
                     "Scenario file (TOML). Without one: the paper's conditions");
  command
      .add_option("--over", options->over,
                  "NAME=FROM:TO:COUNT, once or twice; names: " +
                      fmt::format("{}", fmt::join(scenario_parameter_names(), ", ")))
      ->type_name("AXIS");
  command
      .add_option("-o,--output", options->output,
                  "Write the table: swept names, alpha_rad, v_mm_s and those of the steady motion")
      ->type_name("S.csv")
      ->required();
  add_common(
      command, context,
      "  tribotrack sweep data/figure7a.toml --over phi_rad=0:2pi:73 --over dtau_rad=pi/6:pi:6 -o sweep.csv");
  command.callback([options, &context] { sweep(*options, context); });
}

}  // namespace tribotrack::apps
