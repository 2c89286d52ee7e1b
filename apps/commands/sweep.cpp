// tribotrack sweep: alpha and v over one or two parameters.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>

#include "apps/commands/command.h"
#include "apps/files/meta_file.h"
#include "apps/files/scenario_file.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/angle.h"
#include "apps/text/number_text.h"
#include "apps/text/output_file.h"
#include "model/batch.h"

namespace tribotrack::apps {

namespace {

constexpr double kMostScenarios = 1e8;

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
  if (!from || !to || !count) refuse();
  if (*count < 1 || *count > kMostScenarios || *count != std::floor(*count))
    throw UsageError(
        fmt::format("--over {}: the count, its last number, must be a whole number, 1 to {:.0f}, not {}",
                    text, kMostScenarios, *count));
  if (axis.name.ends_with("_rad"))
    for (const double end : {*from, *to})
      if (const std::string slip = angle_slip(end); !slip.empty())
        throw UsageError(fmt::format("--over {}: {} {}", text, axis.name, slip));
  axis.from = *from;
  axis.to = *to;
  axis.count = static_cast<long>(*count);
  return axis;
}

/// All scenarios' ends and steady motions, on all threads.
model::BatchOutcome solve(std::size_t total, const std::function<model::Scenario(std::size_t)>& scenario_at,
                          const Context& context) {
  Progress progress("sweep", context.quiet);
  model::BatchOptions options;
  options.steady = true;
  options.threads = threads_to_use(context);
  options.progress = [&progress](std::size_t done, std::size_t of) {
    progress.update(static_cast<std::int64_t>(done), static_cast<std::int64_t>(of));
  };
  model::BatchOutcome outcome = model::solve_batch(total, scenario_at, options);
  for (std::size_t k = 0; k < total; ++k) {
    if (outcome.ends[k].status == model::BatchStatus::failed) throw std::runtime_error(outcome.reasons.at(k));
    if (outcome.ends[k].status != model::BatchStatus::done)
      throw model::InvalidParameter(outcome.reasons.at(k));
  }
  return outcome;
}

/// alpha and v, mm/s; empty where there is none.
template <class Solution>
std::string cells(const Solution& solution) {
  if (solution.status != model::BatchStatus::done) return ",";
  return compact(solution.alpha) + "," + compact(solution.v * 1e3);
}

/// One list for each column of the table; null for "no value".
Json columns_of(const std::vector<Axis>& axes, const model::BatchOutcome& outcome) {
  Json json;
  const auto put = [&](const char* alpha, const char* v, const auto& solution) {
    const bool done = solution.status == model::BatchStatus::done;
    json[alpha].push_back(done && std::isfinite(solution.alpha) ? Json(solution.alpha) : Json());
    json[v].push_back(done && std::isfinite(solution.v) ? Json(solution.v * 1e3) : Json());
  };
  const std::size_t inner = axes.size() == 2 ? static_cast<std::size_t>(axes[1].count) : 1;
  for (std::size_t index = 0; index < outcome.ends.size(); ++index) {
    json[axes[0].name].push_back(axes[0].value(static_cast<long>(index / inner)));
    if (axes.size() == 2) json[axes[1].name].push_back(axes[1].value(static_cast<long>(index % inner)));
    put("alpha_rad", "v_mm_s", outcome.ends[index]);
    put("steady_alpha_rad", "steady_v_mm_s", outcome.steady[index]);
  }
  return json;
}

std::vector<Axis> axes_of(const std::vector<std::string>& texts) {
  if (texts.empty() || texts.size() > 2)
    throw UsageError(
        "sweep needs one or two --over NAME=FROM:TO:COUNT (or `over` in [sweep] of the scenario)");
  std::vector<Axis> axes;
  for (const auto& text : texts) axes.push_back(parse_axis(text));
  if (axes.size() == 1) return axes;
  if (axes[0].name == axes[1].name)
    throw UsageError(
        fmt::format("--over names {} twice; give another parameter for the second axis", axes[0].name));
  const auto is_mu2 = [](const Axis& axis) { return axis.name == "mu2" || axis.name == "mu1_over_mu2"; };
  if (is_mu2(axes[0]) && is_mu2(axes[1]))
    throw UsageError("--over names mu2 and mu1_over_mu2, which mean the same; give one of them");
  const double total = static_cast<double>(axes[0].count) * static_cast<double>(axes[1].count);
  if (total > kMostScenarios)
    throw UsageError(fmt::format(
        "--over {} --over {}: {:.0f} scenarios, at most {:.0f} are solved at once; lower the counts",
        texts[0], texts[1], total, kMostScenarios));
  return axes;
}

struct SweepOptions {
  bool json = false;
  std::string scenario;
  std::vector<std::string> over;
  std::string output;
};

void sweep(const SweepOptions& options, const Context& context) {
  const ScenarioFile base = options.scenario.empty() ? ScenarioFile{} : read_scenario_file(options.scenario);
  const auto& texts = options.over.empty() ? base.over : options.over;
  const std::vector<Axis> axes = axes_of(texts);
  if (is_standard_output(options.output)) {
    if (options.json) throw UsageError("give -o - or --json: both would go to standard output");
  } else {
    std::vector<std::filesystem::path> inputs;
    if (!options.scenario.empty()) inputs.emplace_back(options.scenario);
    require_writable({{options.output}}, inputs);
  }

  const std::size_t inner = axes.size() == 2 ? static_cast<std::size_t>(axes[1].count) : 1;
  const std::size_t total = static_cast<std::size_t>(axes[0].count) * inner;
  ScenarioFile common = base;
  common.over.clear();
  const auto scenario_at = [&](std::size_t index) {
    ScenarioFile file = common;
    set_scenario_parameter(file, axes[0].name, axes[0].value(static_cast<long>(index / inner)));
    if (axes.size() == 2)
      set_scenario_parameter(file, axes[1].name, axes[1].value(static_cast<long>(index % inner)));
    file.settle();
    return file.scenario;
  };
  try {
    for (std::size_t index = 0; index < total; ++index)
      scenario_at(index).validate();  // refuse before the work, not after it
  } catch (const model::InvalidParameter& error) {
    throw InvalidInput(fmt::format("--over {}: {}", fmt::join(texts, " --over "), error.what()));
  }
  const model::BatchOutcome outcome = solve(total, scenario_at, context);

  if (options.json) print_text(text_of(columns_of(axes, outcome)));
  std::string table;
  for (const Axis& axis : axes) table += axis.name + ",";
  table += "alpha_rad,v_mm_s,steady_alpha_rad,steady_v_mm_s\n";
  for (std::size_t index = 0; index < total; ++index) {
    table += compact(axes[0].value(static_cast<long>(index / inner))) + ",";
    if (axes.size() == 2) table += compact(axes[1].value(static_cast<long>(index % inner))) + ",";
    table += cells(outcome.ends[index]) + "," + cells(outcome.steady[index]) + "\n";
  }
  MetaFile meta;
  meta.command = "sweep";
  if (!options.scenario.empty()) meta.inputs = {hashed_input(options.scenario)};
  meta.configuration = json_of(base.scenario);
  meta.configuration["over"] = texts;
  write_result(options.output, table, meta);
  say(context.quiet,
      fmt::format("{}: {} scenarios; {}", options.output, total, outcome.summary.full_report()));
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
  command.add_flag("--json", options->json, "Print the table as one JSON object, a list for each column");
  add_common(
      command, context,
      "  tribotrack sweep data/figure7a.toml --over phi_rad=0:2pi:73 --over dtau_rad=pi/6:pi:6 -o sweep.csv");
  command.callback([options, &context] { sweep(*options, context); });
}

}  // namespace tribotrack::apps
