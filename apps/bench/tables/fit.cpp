#include "apps/bench/figures/figures.h"
#include "apps/bench/tables/columns.h"
#include "apps/bench/tables/tables.h"
#include "apps/bench/verdicts/verdicts.h"

namespace tribotrack::bench {
namespace {

auto component(Eigen::Vector3d FitBenchRow::*vector, Eigen::Index i) {
  return [vector, i](const FitBenchRow& row) { return (row.*vector)(i); };
}

}  // namespace

BenchTable table_of(const std::vector<FitBenchRow>& rows) {
  using Row = FitBenchRow;
  const Columns<Row> columns{
      {"data", &Row::data},
      {"method", &Row::method, "method", "<64"},
      {"campaigns", &Row::campaigns},
      {"converged", &Row::converged},
      {"time_s", seconds(&Row::time), "time", ">10"},
      {"solves", [](const Row& r) { return r.solves > 0 ? std::optional(r.solves) : std::nullopt; }},
      {"time_over_ours", &Row::time_over_ours, "x ours", ">7", "{:.2f}"},
      {"off_minimum_sd", &Row::off_minimum},
      {"mu1_rms_error_relative", component(&Row::rms_error, 0)},
      {"mu1_mean_sd_relative", component(&Row::mean_sd, 0)},
      {"mu1_covered", component(&Row::covered, 0)},
      {"mu2_rms_error_relative", component(&Row::rms_error, 1)},
      {"mu2_mean_sd_relative", component(&Row::mean_sd, 1)},
      {"mu2_covered", component(&Row::covered, 1)},
      {"lag_rms_error_rad", component(&Row::rms_error, 2)},
      {"lag_mean_sd_rad", component(&Row::mean_sd, 2)},
      {"lag_covered", component(&Row::covered, 2)},
      {"", [](const Row& r) { return fmt::format("{:>3}/{:<3}", r.converged, r.campaigns); }, "conv.", ">7"},
      {"", [](const Row& r) { return Percent{r.rms_error(0)}; }, "rms mu1", ">9", "{:.4f} %"},
      {"", [](const Row& r) { return Percent{r.rms_error(1)}; }, "mu2", ">8", "{:.3f} %"},
      {"", component(&Row::rms_error, 2), "lag, rad", ">8", "{:.5f}"},
      {"", component(&Row::covered, 0), "holds mu1", ">9", "{:.2f}"},
      {"", component(&Row::covered, 1), "mu2", ">4", "{:.2f}"},
      {"", component(&Row::covered, 2), "lag", ">4", "{:.2f}"},
      {"", &Row::off_minimum, "off, sd", ">9", "{:.1e}"},
      {"", [&](const Row& r) { return verdict(r, rows); }, " against ours", "<", " {}"},
  };
  BenchTable table{"bench_fit", columns.csv(rows), "", columns.html("bench_fit", rows, {"data"})};
  std::string data;
  for (const Row& row : rows) {
    if (row.data != data)
      table.text += fmt::format("\n{}", columns.heading(fmt::format("fits to {}", data = row.data)));
    table.text += columns.line(row);
  }
  table.figures = {fit_error_figure(rows), fit_minimum_figure(rows)};
  return table;
}

BenchTable table_of(const std::vector<CoverageRow>& rows) {
  using Row = CoverageRow;
  const Columns<Row> columns{
      {"design", [](const Row& r) { return std::string(to_string(r.design)); }, "95 % intervals hold in",
       "<24"},
      {"noise", [](const Row& r) { return to_string(r.level); }, "noise", "<5"},
      {"parameter", bare(&Row::parameter), "parameter", "<14"},
      {"campaigns", &Row::campaigns, "campaigns", ">9"},
      {"usable", &Row::usable, "usable", ">6"},
      {"weak", &Row::weak, "weak", ">5"},
      {"open", &Row::open, "open", ">5"},
      {"covered", percent(&Row::share), "covered", ">8", "{:.1f} %"},
      {"covered_low", [](const Row& r) { return Percent{r.share_ci95().low}; }},
      {"covered_high", [](const Row& r) { return Percent{r.share_ci95().high}; }},
      {"",
       [](const Row& r) {
         return fmt::format("{:.1f} to {:.1f} %", 100 * r.share_ci95().low, 100 * r.share_ci95().high);
       },
       "its 95 % range", ">15"},
      {"covered_of_all", percent(&Row::share_of_all), "of all", ">8", "{:.1f} %"},
      {"score", &Row::score, "score", ">6", "{:.2f}"},
  };
  return {"bench_fit_coverage",
          columns.csv(rows),
          fmt::format("\n{}", columns.lines(rows)),
          columns.html("bench_fit_coverage", rows),
          {coverage_figure(rows)}};
}

BenchTable table_of(const std::vector<FilmingRow>& rows) {
  using Row = FilmingRow;
  const Columns<Row> columns{
      {"choice", [](const Row& r) { return std::string(to_string(r.choice)); },
       "runs until mu1 is known to 1 %", "<32"},
      {"noise", [](const Row& r) { return to_string(r.level); }, "noise", "<5"},
      {"campaigns", &Row::campaigns, "campaigns", ">9"},
      {"reached", &Row::reached, "reached", ">7"},
      {"interval_holds", &Row::holds, "interval holds", ">14"},
      {"runs_lower_quartile", &Row::runs_low, "25 %", ">5", "{:.0f}"},
      {"runs_median", &Row::runs_median, "median", ">6", "{:.0f}"},
      {"runs_upper_quartile", &Row::runs_high, "75 %", ">5", "{:.0f}"},
  };
  return {"bench_fit_filming",
          columns.csv(rows),
          fmt::format("\n{}", columns.lines(rows)),
          columns.html("bench_fit_filming", rows),
          {}};
}

}  // namespace tribotrack::bench
