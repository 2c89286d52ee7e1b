#include <cmath>

#include "apps/bench/figures/figures.h"
#include "apps/bench/tables/columns.h"
#include "apps/bench/tables/tables.h"
#include "apps/bench/verdicts/verdicts.h"

namespace tribotrack::bench {
namespace {

/// Nothing where a method has no such setting.
std::optional<Exact> setting(double value) {
  return value > 0 ? std::optional(Exact{value}) : std::nullopt;
}

/// Nothing for a NaN.
template <class Value>
std::optional<Value> unless_nan(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(Value{value});
}

}  // namespace

BenchTable table_of(const std::vector<ModelBenchRow>& rows, const std::vector<std::string>& missing) {
  using Row = ModelBenchRow;
  const Columns<Row> columns{
      {"scene", &Row::scene},
      {"method", &Row::method, "method", "<45"},
      {"tolerance", [](const Row& r) { return setting(r.tolerance); }, "tolerance", ">9", "{:g}"},
      {"max_step_s", [](const Row& r) { return setting(r.max_step); }, "max step", ">10", "{:g} s"},
      {"finished", &Row::finished},
      {"steps", &Row::steps, "steps", ">9"},
      {"end_x_mm", [](const Row& r) { return Exact{r.end.x() * 1e3}; }},
      {"end_y_mm", [](const Row& r) { return Exact{r.end.y() * 1e3}; }},
      {"error_m", exactly(&Row::error), "error, m", ">11", "{:.2g}"},
      {"path_error_m", exactly(&Row::path_error), "of path, m", ">11", "{:.2g}"},
      {"time_s", seconds(&Row::time), "time", ">11"},
      {"repetitions", &Row::repetitions},
      {"time_over_ours", &Row::time_over_ours},
      {"reference", &Row::reference},
      {"", [](const Row& r) { return verdict(r); }, " at the same error", "<", " {}"},
  };
  BenchTable table{"bench_model", columns.csv(rows), "", columns.html("bench_model", rows, {"scene"})};
  std::string scene;
  for (const Row& row : rows) {
    if (row.scene != scene) table.text += fmt::format("\n{}\n  {}", scene = row.scene, columns.heading());
    table.text += fmt::format("  {}", columns.line(row));
  }
  for (const std::string& library : missing)
    table.text +=
        fmt::format("\nnot compared: the solvers of {}, which this build was made without\n", library);
  table.figures = {model_figure(rows)};
  return table;
}

BenchTable table_of(const std::vector<ModelExtremeRow>& rows) {
  using Row = ModelExtremeRow;
  const Columns<Row> columns{
      {"case", &Row::name, "stiff and extreme cases", "<42"},
      {"finite", &Row::finite},
      {"end_x_mm", [](const Row& r) { return Exact{r.end.x() * 1e3}; }},
      {"end_y_mm", [](const Row& r) { return Exact{r.end.y() * 1e3}; }},
      {"", [](const Row& r) { return r.end.norm() * 1e3; }, "end, mm", ">11", "{:.4g}"},
      {"steps", &Row::steps, "steps", ">9"},
      {"stops", &Row::stops},
      {"time_s", seconds(&Row::time), "time", ">9"},
      {"time_per_cycle_over_ordinary", &Row::ratio_per_cycle, "x/cyc", ">6", "{:.2f}"},
      {"", &Row::finite, "finite", ">7"},
      {"", [](const Row& r) { return r.one_sided ? "one side" : yes(r.derivatives_finite); }, "d finite",
       ">9"},
      {"invariant", &Row::invariant},
      {"violation", &Row::violation, "violated", ">9", "{:.1e}"},
      {"allowed", &Row::allowed, "allowed", ">8", "{:.1e}"},
      {"held", &Row::held},
      {"derivatives_finite", &Row::derivatives_finite},
      {"one_sided", &Row::one_sided},
      {"failure", &Row::failure},
      {"",
       [](const Row& r) {
         return (r.held ? "held: " : "BROKEN: ") + (r.failure.empty() ? r.invariant : r.failure);
       },
       " law", "<", " {}"},
  };
  const Columns<Row> on_page{
      {"", &Row::name, "case", "<"},
      {"", [](const Row& r) { return r.failure.empty() ? r.invariant : r.failure; }, "law that must hold",
       "<"},
      {"", [](const Row& r) { return r.held ? "held" : "BROKEN"; }, "verdict", "<"},
      {"", &Row::violation, "violated by", ">9", "{:.1e}"},
      {"", &Row::allowed, "allowed", ">8", "{:.1e}"},
      {"", seconds(&Row::time), "time", ">9"},
      {"", &Row::ratio_per_cycle, "time per cycle, x ordinary", ">6", "{:.2f}"},
  };
  return {"bench_model_extremes", columns.csv(rows), fmt::format("\n{}", columns.lines(rows)),
          on_page.html("bench_model_extremes", rows)};
}

BenchTable table_of(const std::vector<PlanBenchRow>& rows) {
  using Row = PlanBenchRow;
  const Columns<Row> columns{
      {"omission", &Row::omission, "what omissions save", "<18"},
      {"scene", &Row::scene},
      {"time_with_s", seconds(&Row::time_with), "with", ">10"},
      {"time_without_s", seconds(&Row::time_without), "without", ">10"},
      {"saving", percent(&Row::saving), "saved", ">7", "{:.0f} %"},
      {"error_m", [](const Row& r) { return unless_nan<double>(r.error); }, "error, m", ">9", "{:.1e}"},
      {"error_bound_m", &Row::error_bound, "bound, m", ">9", "{:.1e}"},
      {"repetitions", &Row::repetitions},
      {"", &Row::scene, " scene", "<", " {}"},
  };
  return {"bench_model_plan", columns.csv(rows), fmt::format("\n{}", columns.lines(rows)),
          columns.html("bench_model_plan", rows)};
}

BenchTable table_of(const std::vector<BatchBenchRow>& rows) {
  using Row = BatchBenchRow;
  const Columns<Row> columns{
      {"sweep", &Row::sweep},
      {"wanted", bare(&Row::wanted), "many at once", "<12"},
      {"instruction_set", bare(&Row::instruction_set), "lanes", "<9"},
      {"scenarios", &Row::scenarios},
      {"share_in_lanes", percent(&Row::in_lanes), "in lanes", ">9", "{:.1f} %"},
      {"share_of_lanes_used", percent(&Row::full), "full", ">6", "{:.0f} %"},
      {"time_scalar_s", [](const Row& r) { return unless_nan<Seconds>(r.time_scalar); }, "scalar", ">10"},
      {"time_lanes_s", [](const Row& r) { return unless_nan<Seconds>(r.time_lanes); }, "lanes", ">10"},
      {"speedup", [](const Row& r) { return unless_nan<double>(r.speedup); }, "faster", ">8", "x{:.1f}"},
      {"sweep_of_a_million_s", &Row::million, "a million", ">10", "{:.1f} s"},
      {"difference_amplitudes", [](const Row& r) { return unless_nan<double>(r.difference); }, "differ",
       ">10", "{:.1e} A"},
      {"repetitions", &Row::repetitions},
      {"", &Row::sweep, " sweep", "<", " {}"},
  };
  return {"bench_model_batch", columns.csv(rows), fmt::format("\n{}", columns.lines(rows)),
          columns.html("bench_model_batch", rows)};
}

/// The figures of every claim in the CSV, its finding in the text.
BenchTable table_of(const std::vector<PaperClaim>& claims) {
  struct Row {
    std::string claim, verdict, conditions, quantity;
    double value = 0;
    std::string unit;
  };
  const Columns<Row> columns{
      {"claim", &Row::claim},       {"verdict", bare(&Row::verdict)}, {"conditions", &Row::conditions},
      {"quantity", &Row::quantity}, {"value", &Row::value},           {"unit", bare(&Row::unit)},
  };
  const Columns<PaperClaim> on_page{
      {"", &PaperClaim::name, "claim", "<"},
      {"", &PaperClaim::statement, "as the paper has it", "<"},
      {"", &PaperClaim::place, "where", "<"},
      {"", [](const PaperClaim& c) { return to_string(c.verdict); }, "verdict", "<"},
      {"", &PaperClaim::finding, "what was found", "<"},
  };
  BenchTable table{"bench_model_claims", "", "", on_page.html("bench_model_claims", claims)};
  table.text = "\nclaims of the paper (every figure is in the CSV)\n";
  std::vector<Row> rows;
  for (const PaperClaim& claim : claims) {
    table.text += fmt::format("  {:<14} {} ({})\n{:17}{}\n", to_string(claim.verdict), claim.statement,
                              claim.place, "", claim.finding);
    for (const ClaimFigure& f : claim.figures)
      rows.push_back({claim.name, to_string(claim.verdict), f.conditions, f.quantity, f.value, f.unit});
  }
  table.csv = columns.csv(rows);
  return table;
}

}  // namespace tribotrack::bench
