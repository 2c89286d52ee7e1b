#include "fit/measurement.h"

#include <cmath>
#include <numbers>

namespace tribotrack::fit {

PlatformPicture picture_of(const TrackTable& track, const PlatformMotion& motion) {
  PlatformPicture picture;
  const double w = motion.angular_frequency.value, epsilon = motion.phase_shift.value;
  const double half = 0.5 * w * track.exposure;
  const double seen = half > 0 ? std::sin(half) / half : 1;
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

}  // namespace tribotrack::fit
