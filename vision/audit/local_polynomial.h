// What is left of a track when a polynomial is fitted about every frame (Savitzky & Golay, Anal. Chem. 36,
// 1964).
#pragma once

#include <cstddef>
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
  /// Of residuals of white noise of variance 1.
  double variance() const { return correlation(0); }
  /// Correlation of consecutive residuals of errors each of which is `rho` times the last and white noise.
  double lag1(double rho) const;
  /// Variance of the polynomial's value, white noise of variance 1.
  double smoothed_variance() const { return 1 - variance(); }

 private:
  double correlation(std::ptrdiff_t lag) const;
  std::size_t half_;
  std::vector<double> weights_;  ///< of the residual
};

struct Correlation {
  double value = 0;
  double scatter = 0;  ///< standard deviation of the value
};

/// Correlation of a coordinate's errors with those of the next frame: the one with which an autoregression of
/// first order would leave residuals as alike as the track's. 0 for white noise. nullopt from fewer than 50
/// pairs.
std::optional<Correlation> lag1_correlation(const std::vector<Stretch>& stretches, const Axis& axis,
                                            const LocalPolynomial& fit);

}  // namespace tribotrack::vision
