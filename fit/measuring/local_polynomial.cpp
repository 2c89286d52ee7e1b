#include "fit/measuring/local_polynomial.h"

#include <algorithm>

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
