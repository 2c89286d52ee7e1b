// tribotrack sweep: alpha and v over one or two parameters.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <utility>

#include "apps/commands/command.h"
#include "apps/files/meta_file.h"
#include "apps/files/scenario_file.h"
#include "apps/files/sweeps/sweep_axis.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/simulating/swept_model.h"
#include "apps/text/number_text.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

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
