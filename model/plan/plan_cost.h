// What the machinery of the friction model costs, in microseconds of the machine it was measured on (only
// ratios count): from these the plan predicts what it saves. Medians of CPU times over the conditions of the
// source paper (20 cycles, mu1 = 0.05 .. 0.12). `tribotrack bench model` prints predicted beside measured
// savings.
#pragma once

#include <algorithm>
#include <cmath>

namespace tribotrack::model::internal::plan_cost {

/// A cycle that slides at constant friction.
inline constexpr double kSmoothCycle = 4;
/// A cycle with two switches: each begins a new arc, and the speed varies more between them.
inline constexpr double kSwitchedCycle = 13;
/// A stop, the rest after it and the release, beyond the sliding around them.
inline constexpr double kStop = 15;
/// A free slide to its stop, however long.
inline constexpr double kFreeSlide = 33;
/// Newton's method on the one-cycle map, in cycles of a run.
inline constexpr double kOrbitInCycles = 3;
/// An orbit that sticks is found in one cycle and confirmed in a second.
inline constexpr double kStickingOrbitInCycles = 3;
/// Two velocities this close, relative to the speed, count as the same: cycles repeat from there on.
inline constexpr double kSameVelocity = 4e-16;

/// Time of a run with so many derivatives over a plain one.
inline double derivatives(int count) {
  return count <= 0 ? 1.0 : count <= 3 ? 2.0 : count <= 8 ? 2.8 : 4.7;
}

/// Time of a run of which every sample is wanted over one whose end alone is.
inline constexpr double kDense = 2.4;
/// The same where stops and what leads to them cost most.
inline constexpr double kDenseSticking = 1.05;

/// A cycle that begins nearly as the one before did, over one that does not: its arcs are known.
inline constexpr double kSettledCycle = 0.6;

/// Time of so many cycles, of which `differing` differ from the one before, in such cycles. A stick forgets
/// the arcs before it.
inline double every_cycle(double cycles, double differing, bool sticks) {
  return std::fmin(cycles, differing) + (sticks ? 1 : kSettledCycle) * std::fmax(0, cycles - differing);
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
