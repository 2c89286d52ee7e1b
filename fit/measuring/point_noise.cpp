#include <algorithm>
#include <cmath>
#include <map>

#include "fit/measurement.h"
#include "fit/measuring/local_polynomial.h"
#include "fit/tools/statistics.h"

namespace tribotrack::fit {
namespace {

constexpr std::size_t kFewestFrames = 30;
constexpr int kLowestOrder = 2, kHighestOrder = 10;

/// The step between frames that most of them have.
std::int64_t usual_step(const std::vector<std::int64_t>& frames) {
  std::map<std::int64_t, std::size_t> counts;
  for (std::size_t i = 1; i < frames.size(); ++i) ++counts[frames[i] - frames[i - 1]];
  return std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; })->first;
}

/// Sizes of the differences of one order, over the square root of binomial(2 d, d).
std::vector<double> differences(const std::vector<std::int64_t>& frames, const std::vector<double>& values,
                                std::int64_t step, int order) {
  std::vector<double> weights = {1};
  for (int d = 1; d <= order; ++d) {
    weights.push_back(0);
    for (std::size_t k = weights.size() - 1; k > 0; --k) weights[k] -= weights[k - 1];
  }
  double squares = 0;
  for (const double w : weights) squares += w * w;
  std::vector<double> sizes;
  const std::size_t reach = weights.size() - 1;
  for (std::size_t i = 0; i + reach < frames.size(); ++i) {
    if (frames[i + reach] - frames[i] != step * static_cast<std::int64_t>(reach)) continue;
    double sum = 0;
    for (std::size_t k = 0; k <= reach; ++k) sum += weights[k] * (values[i + k] - values[i]);
    sizes.push_back(std::abs(sum) / std::sqrt(squares));
  }
  return sizes;
}

}  // namespace

std::optional<Eigen::Vector2d> point_noise(const std::vector<std::int64_t>& frames,
                                           const std::vector<Eigen::Vector2d>& positions) {
  if (frames.size() < kFewestFrames || frames.size() != positions.size()) return std::nullopt;
  const std::int64_t step = usual_step(frames);
  Eigen::Vector2d noise;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector2d& p : positions) values.push_back(p[axis]);
    std::optional<double> least;
    for (int order = kLowestOrder; order <= kHighestOrder; ++order) {
      const std::vector<double> sizes = differences(frames, values, step, order);
      if (sizes.size() < kFewestFrames - kHighestOrder) break;
      const double sd = internal::kSdPerMad * internal::upper_median(sizes);
      if (!least || sd < *least) least = sd;
    }
    if (!least) return std::nullopt;
    noise[axis] = *least;
  }
  return noise;
}

}  // namespace tribotrack::fit

namespace tribotrack::fit::internal {

LocalPolynomial::LocalPolynomial(const std::vector<double>& times, double time, std::size_t points,
                                 std::size_t left_out) {
  // Grow to both sides in turn; at the track's ends to the side that is left.
  std::size_t below =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  std::size_t above = below;  // [below, above) is taken
  const auto skip = [&](std::size_t i) { return i == left_out; };
  bool to_left = true;
  while (index_.size() < points && (below > 0 || above < times.size())) {
    if ((to_left && below > 0) || above == times.size()) {
      if (--below; !skip(below)) {
        index_.push_back(below);
        to_left = false;
      }
    } else {
      if (!skip(above)) {
        index_.push_back(above);
        to_left = true;
      }
      ++above;
    }
  }
  std::sort(index_.begin(), index_.end());
  for (const std::size_t k : index_) {
    double weight = 1, slope = 0;
    for (const std::size_t j : index_) {
      if (j == k) continue;
      const double width = times[k] - times[j];
      slope = slope * (time - times[j]) / width + weight / width;
      weight *= (time - times[j]) / width;
    }
    weight_.push_back(weight);
    slope_.push_back(slope);
  }
}

Eigen::Vector2d LocalPolynomial::value(const std::vector<Eigen::Vector2d>& positions) const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < index_.size(); ++k) sum += weight_[k] * positions[index_[k]];
  return sum;
}

Eigen::Vector2d LocalPolynomial::derivative(const std::vector<Eigen::Vector2d>& positions) const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < index_.size(); ++k) sum += slope_[k] * positions[index_[k]];
  return sum;
}

WeightedPoints LocalPolynomial::points() const {
  WeightedPoints sum;
  for (std::size_t k = 0; k < index_.size(); ++k) sum.emplace_back(index_[k], weight_[k]);
  return sum;
}

}  // namespace tribotrack::fit::internal
