#include "apps/bench/figures/figures.h"
#include "apps/bench/tables/columns.h"
#include "apps/bench/tables/tables.h"

namespace tribotrack::bench {

BenchTable table_of(const std::vector<ScaleRow>& rows) {
  using Row = ScaleRow;
  const Columns<Row> columns{
      {"series", [](const Row& r) { return r.series; }, "as work grows", "<14"},
      {"size", &Row::size, "size", ">10"},
      {"cpu_s", &Row::cpu, "CPU, s", ">10", "{:.3f}"},
      {"wall_s", &Row::wall, "wall, s", ">10", "{:.3f}"},
      {"memory_bytes", [](const Row& r) { return r.memory; }},
      {"", [](const Row& r) { return r.memory / (1 << 20); }, "memory, MiB", ">12", "{:.1f}"},
      {"file_calls", &Row::file_calls, "file calls", ">10", "{:.0f}"},
  };
  return {"bench_scale",
          columns.csv(rows),
          fmt::format("\n{}", columns.lines(rows)),
          columns.html("bench_scale", rows),
          {scale_figure(rows)}};
}

BenchTable table_of(const std::vector<ScaleExponent>& rows) {
  using Row = ScaleExponent;
  const Columns<Row> columns{
      {"series", [](const Row& r) { return r.series; }, "cost ~ size^n", "<14"},
      {"cost", [](const Row& r) { return r.cost; }, "cost", "<12"},
      {"from", &Row::from, "from", ">10"},
      {"to", &Row::to, "to", ">10"},
      {"exponent", &Row::exponent, "n", ">7", "{:.2f}"},
      {"exponent_sd", &Row::sd, "sd", ">6", "{:.2f}"},
  };
  return {"bench_scale_exponents", columns.csv(rows), fmt::format("\n{}", columns.lines(rows)),
          columns.html("bench_scale_exponents", rows)};
}

}  // namespace tribotrack::bench
