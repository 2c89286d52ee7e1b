// Noise from frame to frame, by differences of high order.
//
// The p-th difference of white noise has the variance C(2p, p) sigma^2: 6, 70, 924 for p = 2, 4, 6. A motion
// that is slow against the frame rate adds less and less to it from order to order. So the lowest order that
// finds no more than the next one is free of the motion; where none is, the motion is too fast for this and
// nothing is said.
//
// For white noise the covariance of two such estimates, relative, is 2/n C(2p + 2q, p + q) / (C(2p, p)
// C(2q, q)) from n differences (Vandermonde's identity for the products of their coefficients), which says
// when two orders differ.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "vision/audit/mean_square.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// The track as the audit looks at it: each coordinate over each stretch of consecutive frames that are ok:
/// positions, px, and their reported standard deviations.
struct Stretch {
  std::vector<double> x, y, sigma_x, sigma_y;
  std::size_t size() const { return x.size(); }
};

std::vector<Stretch> stretches(const Track& track);

/// One coordinate of a stretch.
struct Axis {
  std::vector<double> Stretch::*position;
  std::vector<double> Stretch::*sigma;
};
inline constexpr Axis kAlongX{&Stretch::x, &Stretch::sigma_x}, kAlongY{&Stretch::y, &Stretch::sigma_y};

struct HighFrequency {
  MeanSquare noise;  ///< against the reported variances
  int order = 0;     ///< p
};

/// Of one coordinate; single outliers are left out. nullopt where the motion is too fast or there are fewer
/// than 24 differences.
std::optional<HighFrequency> high_frequency(const std::vector<Stretch>& stretches, const Axis& axis);

/// Errors that alternate make differences larger than white noise of the same size does: what remains of
/// the variance if the errors are an autoregression with this correlation, or a positive one is ignored.
MeanSquare without_alternation(const HighFrequency& found, double correlation);

/// What is left of a track when a polynomial is fitted about every frame (Savitzky & Golay, Anal. Chem. 36,
/// 1964): least squares over 2 h + 1 frames, taken at the middle one.
class LocalPolynomial {
 public:
  /// For a motion that differences of this order do not show (high_frequency): that degree, over twice the
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

// Errors that depend on where between the pixels the part lies.
//
// Residuals about the local polynomial are regressed on what the same polynomial leaves of cos 2 pi x,
// sin 2 pi x, cos 2 pi y, sin 2 pi y of the smoothed positions. Only what a motion through several phases
// shows counts: combinations of these that hardly vary within the polynomial's window are left out, for there
// the noise of the positions themselves would explain the residual.

/// Of one coordinate: 1 + the mean square of the fitted errors in units of the reported variances, less what
/// noise alone would give, `noise` being its variance in those units: 1 where there is nothing. nullopt where
/// the part does not move through the pixels.
std::optional<MeanSquare> pixel_phase(const std::vector<Stretch>& stretches, const Axis& axis,
                                      const LocalPolynomial& fit, double noise);

}  // namespace tribotrack::vision
