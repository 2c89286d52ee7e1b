#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "apps/bench/figures/figures.h"
#include "apps/bench/figures/log_log.h"

namespace tribotrack::bench {

apps::Figure scale_figure(const std::vector<ScaleRow>& rows) {
  struct Cost {
    const char* panel;
    std::function<double(const ScaleRow&)> of;
  };
  const Cost costs[] = {{"CPU time", [](const ScaleRow& row) { return row.cpu; }},
                        {"memory", [](const ScaleRow& row) { return row.memory; }},
                        {"file calls", [](const ScaleRow& row) { return row.file_calls.value_or(0); }}};
  std::vector<LogLogPoint> points;
  for (const auto& [panel, cost] : costs) {
    double largest = 1;
    for (const ScaleRow& row : rows) {
      const ScaleRow& smallest = *std::ranges::find(rows, row.series, &ScaleRow::series);
      if (!(cost(smallest) > 0)) continue;
      const double growth = static_cast<double>(row.size) / smallest.size;
      largest = std::max(largest, growth);
      points.push_back(
          {panel, row.series, row.series,
           fmt::format("{} {}: {:.3g} s, {:.3g} MiB", row.size, row.series, row.cpu, row.memory / (1 << 20)),
           growth, cost(row) / cost(smallest)});
    }
    if (largest > 1)
      for (const double growth : {1.0, largest})
        points.push_back(
            {panel, "in proportion", "in proportion", "in proportion", growth, growth, false, false, true});
  }
  LogLogText text{"scale", "Costs as work grows",
                  "Each series beside its own smallest size. Dashed: in proportion to the work.",
                  "size / smallest size", "cost / cost of the smallest"};
  text.columns = 3;
  return log_log_figure(text, points);
}

}  // namespace tribotrack::bench
