// tribotrack sweep: alpha and v over one or two parameters.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>

#include "apps/commands/command.h"
#include "apps/files/meta_file.h"
#include "apps/files/scenario_file.h"
#include "apps/files/sweeps/sweep_axis.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/number_text.h"
#include "apps/text/output_file.h"
#include "model/batch.h"

namespace tribotrack::apps {

namespace {

/// All scenarios' ends and steady motions, on all threads.
model::BatchOutcome solve(const Sweep& sweep, const Context& context) {
  const std::size_t total = sweep.count();
  Progress progress("sweep", context.quiet);
  model::BatchOptions options;
  options.steady = true;
  options.threads = threads_to_use(context);
  options.progress = [&progress](std::size_t done, std::size_t of) {
    progress.update(static_cast<std::int64_t>(done), static_cast<std::int64_t>(of));
  };
  model::BatchOutcome outcome = model::solve_batch(
      total, [&sweep](std::size_t index) { return sweep.scenario(index); }, options);
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
Json columns_of(const Sweep& sweep, const model::BatchOutcome& outcome) {
  Json json;
  const auto put = [&](const char* alpha, const char* v, const auto& solution) {
    const bool done = solution.status == model::BatchStatus::done;
    json[alpha].push_back(done && std::isfinite(solution.alpha) ? Json(solution.alpha) : Json());
    json[v].push_back(done && std::isfinite(solution.v) ? Json(solution.v * 1e3) : Json());
  };
  for (std::size_t index = 0; index < outcome.ends.size(); ++index) {
    for (std::size_t axis = 0; axis < sweep.axes().size(); ++axis)
      json[sweep.axes()[axis].name()].push_back(sweep.value(index, axis));
    put("alpha_rad", "v_mm_s", outcome.ends[index]);
    put("steady_alpha_rad", "steady_v_mm_s", outcome.steady[index]);
  }
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

  const std::size_t total = sweep.count();
  try {
    for (std::size_t index = 0; index < total; ++index)
      sweep.scenario(index).validate();  // refuse before the work, not after it
  } catch (const model::InvalidParameter& error) {
    throw InvalidInput(fmt::format("--over {}: {}", fmt::join(texts, " --over "), error.what()));
  }
  const model::BatchOutcome outcome = solve(sweep, context);

  if (options.json) print_text(text_of(columns_of(sweep, outcome)));
  std::string table;
  for (const SweepAxis& axis : sweep.axes()) table += axis.name() + ",";
  table += "alpha_rad,v_mm_s,steady_alpha_rad,steady_v_mm_s\n";
  for (std::size_t index = 0; index < total; ++index) {
    for (std::size_t axis = 0; axis < sweep.axes().size(); ++axis)
      table += compact(sweep.value(index, axis)) + ",";
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
                  "NAME=FROM:TO:COUNT or NAME=VALUE,VALUE,..., once or twice; names: " +
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
  command.callback([options, &context] { run_sweep(*options, context); });
}

}  // namespace tribotrack::apps
