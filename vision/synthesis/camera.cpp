#include "vision/synthesis/camera.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/special_functions/legendre.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "vision/kernels/plane.h"

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
  return boost::math::quantile(boost::math::normal(), probability);
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

SceneCamera::SceneCamera(const Scene& scene)
    : flicker_(scene.flicker),
      flicker_hz_(scene.flicker_hz),
      seed_(scene.seed),
      gain_(scene.width, scene.height) {
  const double scale = std::ldexp(1.0, scene.bits - 8);
  read_variance_ = static_cast<float>(scene.read_noise * scene.read_noise * scale * scale);
  variance_per_level_ = static_cast<float>(scene.shot_noise * scale);
  top_level_ = static_cast<float>(std::ldexp(1.0, scene.bits) - 1);
  const double x_middle = (scene.width - 1) / 2.0;
  const double y_middle = (scene.height - 1) / 2.0;
  const double corner = std::max(1.0, x_middle * x_middle + y_middle * y_middle);
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      const double r2 = (x - x_middle) * (x - x_middle) + (y - y_middle) * (y - y_middle);
      gain_.at(x, y) = static_cast<float>(scale * (1 - scene.vignetting * r2 / corner));
    }
  }
}

double SceneCamera::flicker(double time_s, double exposure_s) const {
  const double half_turn = std::numbers::pi * flicker_hz_ * exposure_s;
  const double smoothing = std::abs(half_turn) < 1e-9 ? 1.0 : std::sin(half_turn) / half_turn;
  return 1 + flicker_ * smoothing * std::sin(2 * std::numbers::pi * flicker_hz_ * time_s);
}

void SceneCamera::to_levels(Picture& picture) const {
  for (std::size_t i = 0; i < picture.levels().size(); ++i) picture.levels()[i] *= gain_.levels()[i];
}

void SceneCamera::record(Picture& picture, std::int64_t index) const {
  constexpr std::uint64_t kNoiseStream = 0x6e015e0000000000u;  // away from the streams of the appearance
  const CounterRandom random(seed_, kNoiseStream + static_cast<std::uint64_t>(index));
  const bool noisy = read_variance_ > 0 || variance_per_level_ > 0;
  const std::span<float> levels = picture.levels();
  for (std::size_t i = 0; i < levels.size(); ++i) {
    float level = levels[i];
    if (noisy) {
      const float variance = read_variance_ + variance_per_level_ * std::max(level, 0.0F);
      level += std::sqrt(variance) * random.gaussian(i);
    }
    levels[i] = static_cast<float>(static_cast<int>(std::clamp(level, 0.0F, top_level_) + 0.5F));
  }
}

namespace {

constexpr int kMostPoints = 256;

/// log of C_n = n!^4 / ((2n + 1) (2n)!^3)
double log_error_constant(int n) {
  return 4 * std::lgamma(n + 1.0) - std::log(2 * n + 1.0) - 3 * std::lgamma(2 * n + 1.0);
}

}  // namespace

QuadratureRule gauss_legendre(int points) {
  if (points < 1) throw std::invalid_argument("a quadrature rule needs at least one point");
  QuadratureRule rule;
  for (const double x : boost::math::legendre_p_zeros<double>(points)) {
    const double slope = boost::math::legendre_p_prime(points, x), weight = 1 / ((1 - x * x) * slope * slope);
    for (const double node : {x / 2, -x / 2}) {
      if (node == 0 && !rule.nodes.empty() && rule.nodes.back() == 0) continue;
      rule.nodes.push_back(node);
      rule.weights.push_back(weight);
    }
  }
  return rule;
}

int gauss_points_for_edge(double blur, double tolerance) {
  for (int n = 1; n < kMostPoints; ++n) {
    const double log_bound =
        std::log(0.435) + 0.5 * std::lgamma(2.0 * n) + log_error_constant(n) - 2 * n * std::log(blur);
    if (log_bound < std::log(tolerance)) return n;
  }
  return kMostPoints;
}

int gauss_points_for_wave(double wave_number, double tolerance) {
  for (int n = 1; n < kMostPoints; ++n) {
    if (log_error_constant(n) + 2 * n * std::log(std::abs(wave_number)) < std::log(tolerance)) return n;
  }
  return kMostPoints;
}

namespace {

constexpr int kPathSteps = 16;
constexpr double kAtRest = 1e-9;  // px

ScenePose checked_pose(const std::function<ScenePose(double)>& pose, double time_s) {
  const ScenePose p = pose(time_s);
  for (const double value : {p.disc.x, p.disc.y, p.theta, p.platform.x, p.platform.y}) {
    if (!std::isfinite(value)) {
      throw std::invalid_argument("the pose at t = " + std::to_string(time_s) + " s is not finite");
    }
  }
  return p;
}

}  // namespace

std::vector<ExposureNode> exposure_nodes(double time_s, double exposure_s,
                                         const std::function<ScenePose(double)>& pose, double radius_px,
                                         double smallest_blur_px, double largest_wave_number,
                                         double tolerance) {
  if (!(exposure_s >= 0) || !std::isfinite(exposure_s) || !std::isfinite(time_s)) {
    throw std::invalid_argument("time and exposure must be finite and the exposure not negative");
  }
  if (exposure_s == 0) return {{1.0, checked_pose(pose, time_s)}};

  double path_disc = 0, path_platform = 0;
  ScenePose previous = checked_pose(pose, time_s - exposure_s / 2);
  for (int i = 1; i <= kPathSteps; ++i) {
    const ScenePose next =
        checked_pose(pose, time_s + exposure_s * (static_cast<double>(i) / kPathSteps - 0.5));
    path_disc += distance(previous.disc, next.disc) + radius_px * std::abs(next.theta - previous.theta);
    path_platform += distance(previous.platform, next.platform);
    previous = next;
  }
  const double path = std::max(path_disc, path_platform);
  if (path < kAtRest) return {{1.0, checked_pose(pose, time_s)}};

  const int points = std::max(gauss_points_for_edge(smallest_blur_px / path, tolerance),
                              gauss_points_for_wave(largest_wave_number * path, tolerance));
  const QuadratureRule rule = gauss_legendre(points);
  std::vector<ExposureNode> nodes;
  for (int i = 0; i < points; ++i) {
    nodes.push_back({rule.weights[i], checked_pose(pose, time_s + exposure_s * rule.nodes[i])});
  }
  return nodes;
}

}  // namespace tribotrack::vision
