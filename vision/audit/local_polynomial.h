// What is left of a track when a polynomial is fitted about every frame (Savitzky & Golay, Anal. Chem. 36,
// 1964).
#pragma once

#include <optional>
#include <vector>

#include "vision/audit/stretches.h"

namespace tribotrack::vision {

/// Least squares of a polynomial over 2 h + 1 frames, taken at the middle one.
class LocalPolynomial {
 public:
  /// For a motion that differences of this order do not show (differences.h): that degree, over twice the
  /// frames it needs, which leaves most of the noise.
  explicit LocalPolynomial(int order);

  std::size_t half() const { return half_; }
  /// At every frame but the first and last `half`: the value less the polynomial's.
  std::vector<double> residual(const std::vector<double>& values) const;
  /// Transposed: from a number for each of those to one for each of `size` frames.
  std::vector<double> transposed(const std::vector<double>& residuals, std::size_t size) const;
  /// The polynomial itself; first and last frames as they are.
  std::vector<double> smoothed(const std::vector<double>& values) const;
  /// Of residuals of white noise.
  double variance() const { return correlation(0); }
  double lag1() const { return correlation(1) / correlation(0); }
  /// Variance of the polynomial's value, white noise of variance 1.
  double smoothed_variance() const { return 1 - variance(); }

 private:
  double correlation(std::size_t lag) const;
  std::size_t half_;
  std::vector<double> weights_;  ///< of the residual
};

/// Correlation of the track's residuals with those of the next frame, less what the polynomial makes of white
/// noise: r -> (r - r0) / (1 - r r0), which takes r0 to 0 and keeps -1 and 1. nullopt from fewer than 100
/// pairs of both coordinates (a scatter of 0.1).
std::optional<double> lag1_correlation(const std::vector<Stretch>& stretches, const LocalPolynomial& fit);

}  // namespace tribotrack::vision
