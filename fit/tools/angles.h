// Angles on the circle.
#pragma once

#include <cmath>
#include <numbers>

namespace tribotrack::fit::internal {

inline constexpr double pi = std::numbers::pi;
inline constexpr double turn = 2 * pi;

/// The angle in [0, 2 pi): 0 also where a tiny negative one would round to 2 pi.
inline double into_circle(double angle) {
  const double turned = std::fmod(angle, turn);
  const double positive = turned < 0 ? turned + turn : turned;
  return positive >= turn ? 0 : positive;
}

}  // namespace tribotrack::fit::internal
