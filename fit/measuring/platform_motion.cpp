#include <algorithm>
#include <cmath>
#include <numbers>

#include "fit/measurement.h"
#include "fit/measuring/sine_fit.h"
#include "fit/tools/angles.h"
#include "model/alpha_v.h"

namespace tribotrack::fit {
namespace {

using internal::into_circle;
using internal::MarkerSeries;
using internal::pi;
using internal::SineFit;

constexpr double kColoured = 1.5;  ///< power beside w above which noise is not taken for white

/// Amplitude and phase p of a cos(wt) + b sin(wt) = A cos(wt + p), with p moved to time zero.
struct Wave {
  Estimate amplitude, phase;
  double phase_in_middle = 0, phase_in_middle_sd = 0;
  Eigen::Matrix<double, 9, 1> phase_row = Eigen::Matrix<double, 9, 1>::Zero();
};

Wave wave(const SineFit& fit, int axis, double middle) {
  const double a = fit.coefficients(2, axis), b = fit.coefficients(3, axis);
  const double amplitude = std::hypot(a, b);
  Wave result;
  Eigen::Matrix<double, 9, 1> amplitude_row = Eigen::Matrix<double, 9, 1>::Zero();
  if (amplitude > 0) {
    amplitude_row.segment<2>(4 * axis + 2) << a / amplitude, b / amplitude;
    result.phase_row.segment<2>(4 * axis + 2) << b / (amplitude * amplitude), -a / (amplitude * amplitude);
  }
  result.phase_in_middle_sd = std::sqrt(result.phase_row.dot(fit.covariance * result.phase_row));
  result.phase_row(8) = -middle;
  result.amplitude = {amplitude, std::sqrt(amplitude_row.dot(fit.covariance * amplitude_row))};
  result.phase_in_middle = std::atan2(-b, a);
  result.phase = {std::atan2(-b, a) - fit.w * middle,
                  std::sqrt(result.phase_row.dot(fit.covariance * result.phase_row))};
  return result;
}

/// Share of the circle's radius that an exposure of T leaves to be seen: the mean of cos over it.
double seen_share(double w, double exposure) {
  const double half = 0.5 * w * exposure;
  return half > 0 ? std::sin(half) / half : 1;
}

/// Of the amplitude, relative: anything from no exposure to a whole frame interval is possible, a one-sided
/// doubt. 0 where the exposure is known.
double doubt_of(double w, const TrackTable& track) {
  if (track.exposure > 0) return 0;
  const double interval =
      (track.time.back() - track.time.front()) / static_cast<double>(track.time.size() - 1);
  return (1 - std::max(0.2, seen_share(w, interval))) / std::sqrt(3.0);
}

/// The platform's own amplitude from that of its picture.
Estimate sharpened(const Estimate& seen, double w, const TrackTable& track) {
  if (track.exposure > 0) {
    const double share = seen_share(w, track.exposure);
    return share > 0.2 ? Estimate{seen.value / share, seen.sd / share} : seen;
  }
  return {seen.value, std::hypot(seen.sd, doubt_of(w, track) * seen.value)};
}

/// Variance of the marker's noise over its sigma squared, and the covariance of the fit with it.
double widen(SineFit& fit, const MarkerSeries& marker) {
  const double excess = fit.chi2 / (2.0 * static_cast<double>(marker.size()) - 9);
  const double factor = marker.has_sigma() ? std::max(1.0, excess) : excess;
  fit.covariance *= factor;
  return factor;
}

}  // namespace

bool PlatformMotion::frequency_drifts() const {
  return frequency_drift && std::abs(frequency_drift->value) > 4 * frequency_drift->sd;
}

std::optional<PlatformMotion> measure_platform_motion(const TrackTable& track) {
  if (track.marker.empty()) return std::nullopt;
  if (track.marker.size() != track.time.size())
    throw DataError("The track has a marker in some rows only; track the recording again.");
  constexpr std::size_t fewest = 12;
  if (track.time.size() < fewest) return std::nullopt;

  const MarkerSeries marker(track);
  const std::size_t n = marker.size();
  SineFit fit = internal::fit_sine(marker);
  if (!(fit.w > 0)) return std::nullopt;

  PlatformMotion motion;
  motion.broken = internal::break_of(marker, fit);
  motion.drift = marker.span() * fit.coefficients.row(1).transpose();
  const double white = widen(fit, marker);
  const internal::SineResiduals left = internal::analyse_residuals(marker, fit, white);
  if (left.near_w > kColoured * white) fit.covariance *= left.near_w / white;
  for (const Eigen::Index k : {2, 3, 6, 7}) fit.covariance(k, k) += left.repeating_variance;
  motion.frequency_drift = left.frequency_drift;
  motion.harmonics = left.harmonics;
  const Wave x = wave(fit, 0, marker.middle()), y = wave(fit, 1, marker.middle());

  // At rest: the sine is below the noise it sits in.
  const double mean_square = fit.residual_square / (2.0 * static_cast<double>(n));
  const double signal =
      0.25 * (x.amplitude.value * x.amplitude.value + y.amplitude.value * y.amplitude.value);
  double noise = mean_square;
  if (marker.has_sigma()) {
    double own = 0;
    for (const double sigma : track.marker_sigma) own += sigma * sigma;
    noise = std::max(noise, own / static_cast<double>(n));
  }
  if (!(signal > noise)) return std::nullopt;

  motion.amplitude = sharpened(x.amplitude, fit.w, track);
  motion.amplitude_y = sharpened(y.amplitude, fit.w, track);
  motion.exposure_doubt = doubt_of(fit.w, track);
  motion.angular_frequency = {fit.w, std::sqrt(fit.covariance(8, 8))};
  motion.residual_rms = std::sqrt(mean_square);
  const bool moves_x = x.amplitude.value > 3 * x.amplitude.sd;
  const bool moves_y = y.amplitude.value > 3 * y.amplitude.sd;
  // Motion along one axis only leaves epsilon open; 0 is written with the sd of an unknown angle.
  const Wave& leading = moves_x ? x : y;
  motion.phase_at_zero = {into_circle(leading.phase.value), leading.phase.sd};
  motion.phase_at_middle = {leading.phase_in_middle, leading.phase_in_middle_sd};
  motion.middle_time = marker.middle();
  if (moves_x && moves_y) {
    const Eigen::Matrix<double, 9, 1> row = y.phase_row - x.phase_row;
    motion.phase_shift = {model::wrap_angle(y.phase.value - x.phase.value),
                          std::sqrt(row.dot(fit.covariance * row))};
    motion.clockwise = std::sin(motion.phase_shift.value) > 0;
  } else {
    motion.phase_shift = {0, pi / std::sqrt(3.0)};
  }
  return motion;
}

PlatformPicture picture_of(const TrackTable& track, const PlatformMotion& motion) {
  PlatformPicture picture;
  const double w = motion.angular_frequency.value, epsilon = motion.phase_shift.value;
  const double seen = seen_share(w, track.exposure);
  const double a = seen * motion.amplitude.value, b = seen * motion.amplitude_y.value;
  const auto at = [&](double wt) { return Eigen::Vector2d(a * std::cos(wt), b * std::cos(wt + epsilon)); };
  const auto slope = [&](double wt) {
    return Eigen::Vector2d(-a * std::sin(wt), -b * std::sin(wt + epsilon));
  };
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < track.marker.size(); ++i)
    centre += (track.marker[i] - at(w * track.time[i] + motion.phase_at_zero.value)) /
              static_cast<double>(track.marker.size());
  for (std::size_t i = 0; i < track.marker.size(); ++i) {
    const double wt = w * track.time[i] + motion.phase_at_zero.value;
    const Eigen::Vector2d here = track.marker[i] - centre, along = slope(wt);
    picture.orbit.push_back(here);
    const bool moves = along.squaredNorm() > 0.05 * (a * a + b * b);
    picture.phase_left.push_back(moves ? (here - at(wt)).dot(along) / along.squaredNorm() : std::nan(""));
  }
  constexpr int points = 120;
  for (int k = 0; k <= points; ++k) picture.model.push_back(at(2 * std::numbers::pi * k / points));
  return picture;
}

Displacement with_scale_sd(Displacement displacement, double relative_sd) {
  displacement.covariance +=
      relative_sd * relative_sd * displacement.vector * displacement.vector.transpose();
  derive_alpha_and_v(displacement);
  return displacement;
}

PlatformMotion with_scale_sd(PlatformMotion motion, double relative_sd) {
  for (Estimate* length : {&motion.amplitude, &motion.amplitude_y})
    length->sd = std::hypot(length->sd, relative_sd * length->value);
  return motion;
}

}  // namespace tribotrack::fit
