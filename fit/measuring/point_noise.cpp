#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "fit/measurement.h"
#include "fit/tools/statistics.h"

namespace tribotrack::fit {
namespace {

constexpr std::size_t kFewestFrames = 30;
constexpr int kLowestOrder = 2, kHighestOrder = 10;
constexpr double kBeyondChance = 2.5;  ///< sds

/// The step between frames that most of them have.
std::int64_t usual_step(const std::vector<std::int64_t>& frames) {
  std::map<std::int64_t, std::size_t> counts;
  for (std::size_t i = 1; i < frames.size(); ++i) ++counts[frames[i] - frames[i - 1]];
  return std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; })->first;
}

/// Those of a difference, their squares adding up to 1.
std::vector<double> weights_of(int order) {
  std::vector<double> weights = {1};
  for (int d = 1; d <= order; ++d) {
    weights.push_back(0);
    for (std::size_t k = weights.size() - 1; k > 0; --k) weights[k] -= weights[k - 1];
  }
  const double length = std::sqrt(std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0));
  for (double& w : weights) w /= length;
  return weights;
}

/// Covariance of |x| < q and |y| < q, x and y normal with correlation `rho`, q the median of |x|: Mehler's
/// series,
///   sum_j (2 phi(q) He_{2j-1}(q))^2 / (2j)! rho^{2j}.
double both_small(double rho) {
  constexpr double q = 1 / internal::kSdPerMad;
  constexpr int kTerms = 12;
  if (std::abs(rho) > 1 - 1e-9) return 0.25;
  const double density = std::exp(-0.5 * q * q) / std::sqrt(2 * std::numbers::pi);
  double even = 1, odd = q, factorial = 1, power = 1, sum = 0;  // He_{2j-2}, He_{2j-1}
  for (int j = 1; j <= kTerms; ++j) {
    factorial *= (2 * j - 1) * (2 * j);
    power *= rho * rho;
    sum += std::pow(2 * density * odd, 2) / factorial * power;
    even = q * odd - (2 * j - 1) * even;
    odd = q * even - 2 * j * odd;
  }
  return sum;
}

/// Covariance of ln s^2 of two orders, s from medians of n differences of white noise, times n.
double covariance(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr double q = 1 / internal::kSdPerMad;
  const double density = 2 * std::exp(-0.5 * q * q) / std::sqrt(2 * std::numbers::pi);  // of |x| at q
  double sum = 0;
  for (std::size_t shift = 0; shift + 1 < a.size() + b.size(); ++shift) {
    double rho = 0;
    for (std::size_t k = 0; k < a.size(); ++k)
      if (const std::size_t other = k + b.size() - 1 - shift; k + b.size() > shift && other < b.size())
        rho += a[k] * b[other];
    sum += both_small(rho);
  }
  return 4 * sum / std::pow(q * density, 2);
}

/// Median size of the differences as an sd, and how many there are.
struct Scatter {
  double sd = 0, count = 0;
};
Scatter scatter(const std::vector<std::int64_t>& frames, const std::vector<double>& values, std::int64_t step,
                const std::vector<double>& weights) {
  std::vector<double> sizes;
  const std::size_t reach = weights.size() - 1;
  for (std::size_t i = 0; i + reach < frames.size(); ++i) {
    if (frames[i + reach] - frames[i] != step * static_cast<std::int64_t>(reach)) continue;
    double sum = 0;
    for (std::size_t k = 0; k <= reach; ++k) sum += weights[k] * (values[i + k] - values[i]);
    sizes.push_back(std::abs(sum));
  }
  if (sizes.size() < kFewestFrames - kHighestOrder) return {};
  return {internal::kSdPerMad * internal::upper_median(sizes), static_cast<double>(sizes.size())};
}

/// The orders' weights, and the covariances of what they tell.
struct Orders {
  std::vector<std::vector<double>> weights;
  Eigen::MatrixXd covariances;  ///< times the number of differences
};

const Orders& orders() {
  static const Orders all = [] {
    Orders made;
    for (int order = kLowestOrder; order <= kHighestOrder; ++order) made.weights.push_back(weights_of(order));
    const auto n = static_cast<Eigen::Index>(made.weights.size());
    made.covariances.resize(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        made.covariances(i, j) =
            covariance(made.weights[static_cast<std::size_t>(i)], made.weights[static_cast<std::size_t>(j)]);
    return made;
  }();
  return all;
}

/// sd, and the variance of ln sd^2.
struct AxisNoise {
  double sd = 0, variance = 0;
};

std::optional<AxisNoise> axis_noise(const std::vector<std::int64_t>& frames,
                                    const std::vector<double>& values, std::int64_t step) {
  std::vector<Scatter> seen;
  for (const std::vector<double>& weights : orders().weights) {
    const Scatter here = scatter(frames, values, step, weights);
    if (!(here.count > 0)) break;
    seen.push_back(here);
  }
  const auto below_by_chance = [&](std::size_t low, std::size_t high) {
    const auto i = static_cast<Eigen::Index>(low), j = static_cast<Eigen::Index>(high);
    const Eigen::MatrixXd& c = orders().covariances;
    const double variance = (c(i, i) + c(j, j) - 2 * c(i, j)) / seen[high].count;
    return 2 * std::log(seen[low].sd / seen[high].sd) < kBeyondChance * std::sqrt(variance);
  };
  for (std::size_t i = 0; i < seen.size(); ++i) {
    bool lowest = true;
    for (std::size_t j = i + 1; j < seen.size(); ++j) lowest = lowest && below_by_chance(i, j);
    const auto k = static_cast<Eigen::Index>(i);
    if (lowest) return AxisNoise{seen[i].sd, orders().covariances(k, k) / seen[i].count};
  }
  return std::nullopt;
}

}  // namespace

std::optional<PointNoise> point_noise(const std::vector<std::int64_t>& frames,
                                      const std::vector<Eigen::Vector2d>& positions) {
  if (frames.size() < kFewestFrames || frames.size() != positions.size()) return std::nullopt;
  const std::int64_t step = usual_step(frames);
  const double best = 2 / static_cast<double>(frames.size());  // variance of ln s^2 of the best estimate
  PointNoise noise;
  double variance = 0;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector2d& p : positions) values.push_back(p[axis]);
    const auto found = axis_noise(frames, values, step);
    if (!found) return std::nullopt;
    // So that residuals over it have the mean that they should: E(1/s^2) is 1/sigma^2.
    noise.sd[axis] = found->sd * std::sqrt(1 + std::max(0.0, found->variance - best));
    variance += 0.5 * found->variance;
  }
  noise.dof = 2 / std::max(variance - 2 * best, 0.5 * best);
  return noise;
}

}  // namespace tribotrack::fit
