// A circle with free w through the marker's positions, least squares over all frames, and what its
// residuals tell.
//
// Model, per axis: m(t) = offset + drift t + a cos(wt) + b sin(wt), w common; t from the middle of the track,
// so that offset and drift, and phase and w, decouple.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "fit/measurement.h"
#include "fit/track_table.h"

namespace tribotrack::fit::internal {

/// The marker's columns of a track with their weights.
class MarkerSeries {
 public:
  explicit MarkerSeries(const TrackTable& track)
      : track_(track), middle_(0.5 * (track.time.front() + track.time.back())) {}
  std::size_t size() const { return track_.marker.size(); }
  double time(std::size_t i) const { return track_.time[i] - middle_; }  ///< s, from the middle
  double middle() const { return middle_; }
  double span() const { return time(size() - 1) - time(0); }
  const Eigen::Vector2d& at(std::size_t i) const { return track_.marker[i]; }
  double weight(std::size_t i) const;  ///< 1/variance; 1 where the track has no sigma
  bool has_sigma() const;

 private:
  const TrackTable& track_;
  double middle_;
};

struct SineFit {
  Eigen::Matrix<double, 4, 2> coefficients = Eigen::Matrix<double, 4, 2>::Zero();  ///< offset, drift, a, b
  double w = 0;
  double chi2 = 0;
  double residual_square = 0;                                                    ///< sum over both axes, m^2
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();  ///< x4, y4, w; unscaled

  Eigen::Vector2d at(double t) const;  ///< the model
};

/// w from the strongest line of a periodogram over a block in the middle, refined by Gauss-Newton over
/// growing blocks so that no cycle can slip. w = 0 where there is no line. `start`: w is near this, and is
/// not looked for.
SineFit fit_sine(const MarkerSeries& marker, double start = 0);

/// Where the motion breaks, found among all frames: from there on it is moved and goes on at another time, as
/// after a knock at the camera and after frames that are missing in silence. A column of x, of y and of time
/// each are added to the fit; nothing where these do not take most of chi^2, or may by chance.
/// `fit.covariance` as fit_sine() leaves it.
std::optional<MotionBreak> break_of(const MarkerSeries& marker, const SineFit& fit);

struct SineResiduals {
  double near_w = 1;  ///< power of the residuals beside w over that of white noise of the track's sigma
  /// Variance of a cosine or sine coefficient at w by errors that repeat every cycle, m^2: mean square of the
  /// coefficients at 4w and above beyond their noise. 0 where the frames do not resolve them.
  double repeating_variance = 0;
  std::optional<Estimate> frequency_drift;  ///< rad/s^2
  std::vector<Harmonic> harmonics;
};

/// `noise_factor`: variance of the marker's noise over its sigma squared.
SineResiduals analyse_residuals(const MarkerSeries& marker, const SineFit& fit, double noise_factor);

}  // namespace tribotrack::fit::internal
