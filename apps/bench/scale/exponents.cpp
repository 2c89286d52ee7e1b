#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/bench/scale/scale.h"

namespace tribotrack::bench {

namespace {

constexpr std::size_t kLargest = 3;

/// (size, cost), growing.
using Costs = std::vector<std::pair<double, double>>;

ScaleExponent slope_of(const Costs& costs) {
  const auto count = static_cast<double>(costs.size());
  double mean_x = 0, mean_y = 0;
  for (const auto& [size, cost] : costs) {
    mean_x += std::log(size) / count;
    mean_y += std::log(cost) / count;
  }
  double xx = 0, xy = 0;
  for (const auto& [size, cost] : costs) {
    xx += std::pow(std::log(size) - mean_x, 2);
    xy += (std::log(size) - mean_x) * (std::log(cost) - mean_y);
  }
  ScaleExponent fitted;
  fitted.exponent = xy / xx;
  double squares = 0;
  for (const auto& [size, cost] : costs)
    squares += std::pow(std::log(cost) - mean_y - fitted.exponent * (std::log(size) - mean_x), 2);
  if (costs.size() > 2) fitted.sd = std::sqrt(squares / (count - 2) / xx);
  fitted.from = static_cast<int>(costs.front().first);
  fitted.to = static_cast<int>(costs.back().first);
  return fitted;
}

}  // namespace

std::vector<ScaleExponent> exponents(const std::vector<ScaleRow>& rows) {
  std::vector<std::string> names;
  for (const ScaleRow& row : rows)
    if (std::ranges::find(names, row.series) == names.end()) names.push_back(row.series);
  std::vector<ScaleExponent> found;
  for (const std::string& series : names)
    for (const char* cost : {"cpu", "memory", "file calls"}) {
      Costs costs;
      for (const ScaleRow& row : rows) {
        const double value = cost[0] == 'c'   ? row.cpu
                             : cost[0] == 'm' ? row.memory
                                              : row.file_calls.value_or(0);
        if (row.series == series && value > 0) costs.emplace_back(row.size, value);
      }
      if (costs.size() > kLargest) costs.erase(costs.begin(), costs.end() - kLargest);
      if (costs.size() < 2) continue;
      found.push_back(slope_of(costs));
      found.back().series = series;
      found.back().cost = cost;
    }
  return found;
}

}  // namespace tribotrack::bench
