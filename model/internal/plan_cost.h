// What the machinery of the friction model costs, in plain Taylor steps: from these the plan predicts what it
// saves. Medians of CPU times over the conditions of the source paper (20 cycles, mu1 = 0.02 .. 0.4); how to
// measure them again: `tribotrack bench model` prints predicted beside measured savings.
#pragma once

#include <algorithm>
#include <cmath>

namespace tribotrack::model::internal::plan_cost {

/// Steps of a cycle that slides at constant friction.
inline constexpr double kSmoothCycle = 6.5;
/// Steps of a cycle with two switches: each begins a new series, and the speed varies more between them.
inline constexpr double kSwitchedCycle = 22;
/// A stop, the rest after it and the release, beyond the sliding around them.
inline constexpr double kStop = 25;
/// A free slide to its stop, however long.
inline constexpr double kFreeSlide = 25;
/// Newton's method on the one-cycle map: cycles' worth of plain steps, with derivatives by the velocity.
inline constexpr double kOrbitInCycles = 11;
/// An orbit that sticks is found in one cycle and confirmed in a second.
inline constexpr double kStickingOrbitInCycles = 5;
/// Two velocities this close, relative to the speed, count as the same: cycles repeat from there on.
inline constexpr double kSameVelocity = 4e-16;

/// Time of a run with so many derivatives over a plain one.
inline double derivatives(int count) {
  return count <= 0 ? 1.0 : count <= 3 ? 2.2 : count <= 8 ? 3.4 : 9.3;
}

/// Cycles that are integrated until one repeats the last, for a contraction per cycle. A part that sticks
/// (contraction 0) repeats at once.
inline double cycles_until_repeating(double contraction) {
  if (!(contraction > 0)) return 2;
  if (!(contraction < 1)) return HUGE_VAL;
  return 3 + std::ceil(std::log(kSameVelocity) / std::log(contraction));
}

/// Share of the time saved.
inline double saving(double without, double with) {
  return with > 0 ? std::clamp(1 - without / with, 0.0, 1.0) : 0;
}

}  // namespace tribotrack::model::internal::plan_cost
