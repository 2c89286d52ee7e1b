#include "fit/checks/runs_test.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace tribotrack::fit::internal {
namespace {

/// P(no more than `seen` runs among `up` and `down` signs), normal approximation.
double few_runs(int seen, double up, double down) {
  if (up < 4 || down < 4) return 1;
  const double n = up + down, mean = 1 + 2 * up * down / n;
  const double variance = (mean - 1) * (mean - 2) / (n - 1);
  return 0.5 * std::erfc(-(seen + 0.5 - mean) / std::sqrt(2 * variance));
}

}  // namespace

double runs_test(const std::vector<RunResult>& runs) {
  struct Row {
    double width, phi, along, across;
  };
  std::vector<Row> rows;
  for (const RunResult& run : runs) {
    if (run.points > 0 || run.prediction || run.residuals.size() < 2) continue;
    const Residual &x = run.residuals[0], &y = run.residuals[1];
    const Eigen::Vector2d difference(x.measured - x.modelled, y.measured - y.modelled);
    const Eigen::Vector2d along = Eigen::Vector2d(x.modelled, y.modelled).normalized();
    const auto& friction = run.fitted.friction;
    rows.push_back({friction.pulse_width, friction.phase, along.dot(difference),
                    along.x() * difference.y() - along.y() * difference.x()});
  }
  if (rows.size() < 8) return 1;
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    return std::tie(a.width, a.phi) < std::tie(b.width, b.phi);
  });
  double smallest = 1;
  for (double Row::*component : {&Row::along, &Row::across}) {
    int changes = 1, up = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      up += rows[i].*component > 0;
      if (i > 0 && (rows[i].*component > 0) != (rows[i - 1].*component > 0)) ++changes;
    }
    smallest = std::min(smallest, few_runs(changes, up, static_cast<double>(rows.size()) - up));
  }
  return std::min(1.0, 2 * smallest);  // of two components
}

}  // namespace tribotrack::fit::internal
