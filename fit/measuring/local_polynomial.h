// Interpolation through the tracked points nearest to a time.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "fit/tools/track_errors.h"

namespace tribotrack::fit::internal {

/// The polynomial through `points` neighbours of `time`, as many before as after where the track allows
/// (Lagrange's form: value and slope are weighted sums of the points, so their noise is known).
class LocalPolynomial {
 public:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  /// `times` increase. The point `left_out` is not used.
  LocalPolynomial(const std::vector<double>& times, double time, std::size_t points,
                  std::size_t left_out = none);

  Eigen::Vector2d value(const std::vector<Eigen::Vector2d>& positions) const;
  Eigen::Vector2d derivative(const std::vector<Eigen::Vector2d>& positions) const;
  /// The value as a sum of points.
  WeightedPoints points() const;

 private:
  std::vector<std::size_t> index_;
  std::vector<double> weight_, slope_;
};

}  // namespace tribotrack::fit::internal
