#include <fmt/format.h>

#include "apps/bench/figures/figures.h"
#include "apps/bench/figures/log_log.h"
#include "apps/bench/verdicts/verdicts.h"

namespace tribotrack::bench {

apps::Figure tracking_figure(const std::vector<VisionBenchRow>& rows) {
  std::vector<LogLogPoint> points;
  for (const VisionBenchRow& row : rows)
    if (row.noise == kDrawnNoise)
      points.push_back({fmt::format("{}, R = {:g} px", row.scene, row.radius), row.method, row.method,
                        row.method, row.time, row.rms / row.bound, row.ours, peer_wins(row), false});
  LogLogText text{"tracking-error-time", "Error of a position against run time", "", "CPU time per frame, s",
                  "rms error / limit"};
  text.caption = fmt::format(
      "A point is a method; nearer to the lower left corner is better, and 1 is the limit, the Cramér-Rao "
      "bound, that no unbiased "
      "method falls "
      "below. Noise of {:g} grey levels.",
      kDrawnNoise);
  text.columns = 3;
  return log_log_figure(text, points);
}

}  // namespace tribotrack::bench
