// alpha and v, the paper's two numbers for a run (section 2.2), from its displacement relative to the
// platform.
//   const Eigen::Vector2d moved = integrate(scenario).end().position;
//   displacement_angle(moved);                           // alpha, rad
//   mean_velocity(moved, scenario.end_time());           // v, m/s
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

namespace tribotrack::model {

/// alpha = atan2(dy, dx) in [0, 2 pi): the angle from the x axis to the displacement, counter-clockwise. 0
/// for no displacement.
inline double displacement_angle(const Eigen::Vector2d& displacement) {
  const double angle = std::atan2(displacement.y(), displacement.x());
  return angle < 0 ? angle + 2 * std::numbers::pi : angle;
}

/// v = |displacement| / duration, m/s, for m and s > 0.
inline double mean_velocity(const Eigen::Vector2d& displacement, double duration) {
  return displacement.norm() / duration;
}

/// Brings an angle difference into (-pi, pi].
inline double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

}  // namespace tribotrack::model
