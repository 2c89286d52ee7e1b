// A run of eq. (5) cut at its friction switches, for solvers that only know smooth right-hand sides.
#pragma once

#include <algorithm>
#include <cmath>

#include "apps/bench/peers/dormand_prince.h"
#include "apps/bench/peers/library_peers.h"

namespace tribotrack::bench::peers {

using Equation = PlainEquation<double>;
using State = Equation::State;  // x, y, u_x, u_y

/// What a tolerance means in a scene: relative to A (positions) and A w (velocities).
struct Scales {
  double length = 0, speed = 0;
  explicit Scales(const model::Scenario& s)
      : length(std::max(s.drive.amplitude, s.drive.amplitude_y)), speed(length * s.drive.angular_frequency) {}
};

/// Where the run stands.
struct Progress {
  State q{};
  double t = 0;
  long steps = 0;
  long max_steps = 0;
  bool within_budget() const { return steps < max_steps; }
  bool at_rest() const { return q[2] == 0 && q[3] == 0; }
};

inline PeerResult result_of(const Progress& p, double end) {
  return {{p.q[0], p.q[1]}, {p.q[2], p.q[3]}, p.steps, p.t >= end};
}

/// The witness of a stop after a step from velocity `before`: friction exceeds the drive, and the velocity
/// has turned round or is below stop_speed. Sets u = 0.
inline bool stops(const Equation& f, const State& before, double m, double stop_speed, Progress& p) {
  const double turned = before[2] * p.q[2] + before[3] * p.q[3];
  if (turned > 0 && std::hypot(p.q[2], p.q[3]) > stop_speed) return false;
  if (f.drive_size(p.t) > m) return false;
  p.q[2] = p.q[3] = 0;
  return true;
}

/// slide(p, until, m) carries the sliding motion under constant friction m to `until` or to a stop.
template <class Slide>
PeerResult run_in_segments(const Equation& f, Progress p, Slide&& slide) {
  for (const double station : f.stations()) {
    // mu is constant in a segment: its value at the middle is free of rounding at the edges.
    const double m = f.friction((p.t + station) / 2);
    while (p.t < station && p.within_budget()) {
      if (p.at_rest()) p.t = f.release(p.t, station, m);
      if (p.t < station) slide(p, station, m);
    }
  }
  return result_of(p, f.end());
}

inline Progress start_of(const model::Scenario& s, long max_steps) {
  Progress p;
  p.q = {0, 0, s.initial_velocity.x(), s.initial_velocity.y()};
  p.max_steps = max_steps;
  return p;
}

/// Below some tolerances' worth of speed a method no longer knows the direction.
inline double stop_speed(const Scales& scales, double tolerance) {
  return std::max(30 * tolerance, 1e-10) * scales.speed;
}

}  // namespace tribotrack::bench::peers
