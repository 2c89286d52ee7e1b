#include "vision/synthesis/noise.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tribotrack::vision {
namespace {

constexpr int kCellBits = 12;
constexpr int kCells = 1 << kCellBits;

/// Cell i holds the numbers between edges[i] and edges[i + 1]; the two open ends are never read.
const std::array<float, kCells + 1>& cell_edges() {
  static const std::array<float, kCells + 1> edges = [] {
    std::array<float, kCells + 1> table{};
    for (int i = 1; i < kCells; ++i) {
      table[i] = static_cast<float>(normal_quantile(i / static_cast<double>(kCells)));
    }
    return table;
  }();
  return edges;
}

}  // namespace

double normal_quantile(double probability) {
  if (!(probability > 0)) return -std::numeric_limits<double>::infinity();
  if (!(probability < 1)) return std::numeric_limits<double>::infinity();
  if (probability > 0.5) return -normal_quantile(1 - probability);
  // Newton on log Phi(x), which is concave: from the left it converges from any start.
  double x = -std::sqrt(-2 * std::log(probability)) - 0.1;
  for (int iteration = 0; iteration < 50; ++iteration) {
    const double phi = std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi);
    const double cdf = 0.5 * std::erfc(-x / std::numbers::sqrt2);
    const double step = std::log(cdf / probability) * cdf / phi;
    x -= step;
    if (std::abs(step) < 1e-14 * (1 + std::abs(x))) break;
  }
  return x;
}

CounterRandom::CounterRandom(std::uint64_t seed, std::uint64_t stream)
    : key_(mix(mix(seed + 0x9e3779b97f4a7c15u) ^ (stream * 0xd1342543de82ef95u + 1))) {}

float CounterRandom::gaussian(std::uint64_t counter) const {
  static const std::array<float, kCells + 1>& edges = cell_edges();
  const std::uint64_t z = bits(counter);
  const int cell = static_cast<int>(z >> (64 - kCellBits));
  if (cell == 0 || cell == kCells - 1) {
    const double tail = (static_cast<double>(z << kCellBits >> 12) + 0.5) * 0x1p-52 / kCells;
    const double x = normal_quantile(tail);
    return static_cast<float>(cell == 0 ? x : -x);
  }
  const float fraction = static_cast<float>(static_cast<std::uint32_t>(z >> 20) >> 8) * 0x1p-24f;
  return edges[cell] + fraction * (edges[cell + 1] - edges[cell]);
}

}  // namespace tribotrack::vision
