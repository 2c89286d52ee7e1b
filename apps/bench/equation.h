// Eq. (5) as others integrate it, in a floating-point type, and a run of it cut at its friction switches for
// solvers that only know smooth right-hand sides. Shares nothing with the library's own integrator.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "apps/bench/peers.h"

namespace tribotrack::bench {

/// State (x, y, u_x, u_y).
template <class T>
class PlainEquation {
 public:
  using State = std::array<T, 4>;

  explicit PlainEquation(const model::Scenario& s)
      : w_(s.drive.angular_frequency),
        start_phase_(s.start_phase),
        ax_(T(s.drive.amplitude) * w_ * w_),
        ay_cos_(T(s.drive.amplitude_y) * w_ * w_ * std::cos(T(s.drive.phase_shift))),
        ay_sin_(T(s.drive.amplitude_y) * w_ * w_ * std::sin(T(s.drive.phase_shift))),
        tilt_x_(T(s.drive.gravity) * std::sin(T(s.drive.tilt_x))),
        tilt_y_(T(s.drive.gravity) * std::sin(T(s.drive.tilt_y))),
        m1_(T(s.friction.nominal) * T(s.drive.gravity)),
        m2_(T(s.friction.reduced) * T(s.drive.gravity)),
        opens_(T(s.friction.phase) + T(s.friction.lag)),
        width_(s.friction.pulse_width),
        end_(s.duration > 0 ? T(s.duration) : T(s.cycles) * turn() / w_) {
    s.validate();
    if (s.start != model::Start::rest)
      throw std::invalid_argument("the peers integrate from rest or an initial velocity only");
  }

  T end() const { return end_; }
  T frequency() const { return w_; }
  /// mu g at a time.
  T friction(T t) const {
    T into = std::fmod(start_phase_ + w_ * t - opens_, turn());
    if (into < 0) into += turn();
    return into < width_ ? m2_ : m1_;
  }
  void drive(T t, T& x, T& y) const {
    const T c = std::cos(start_phase_ + w_ * t), s = std::sin(start_phase_ + w_ * t);
    x = ax_ * c + tilt_x_;
    y = ay_cos_ * c - ay_sin_ * s + tilt_y_;
  }
  T drive_size(T t) const {
    T x, y;
    drive(t, x, y);
    return std::hypot(x, y);
  }
  /// u' = d - m u / |u|. At u = 0 friction is nothing (as the recipe has it) or opposes the drive.
  State slope(T t, const State& q, T m, bool opposes_drive_at_rest) const {
    T dx, dy;
    drive(t, dx, dy);
    const T speed = std::sqrt(q[2] * q[2] + q[3] * q[3]);
    if (speed > 0) {
      const T f = m / speed;
      return {q[2], q[3], dx - f * q[2], dy - f * q[3]};
    }
    const T size = opposes_drive_at_rest ? std::sqrt(dx * dx + dy * dy) : T(0);
    const T left = size > 0 ? std::max(T(0), 1 - m / size) : T(1);
    return {q[2], q[3], dx * left, dy * left};
  }
  /// Times of the friction switches inside the run, then its end.
  std::vector<T> stations() const {
    std::vector<T> times;
    if (width_ > 0 && width_ < turn())
      for (const T edge : {opens_, opens_ + width_}) {
        const T offset = edge - start_phase_;
        for (T n = std::floor(-offset / turn());; n += 1) {
          const T t = (offset + n * turn()) / w_;
          if (t >= end_) break;
          if (t > 0) times.push_back(t);
        }
      }
    times.push_back(end_);
    std::sort(times.begin(), times.end());
    return times;
  }
  /// First time in [t, last] at which the drive exceeds m; `last` where it never does.
  T release(T t, T last, T m) const {
    const T step = turn() / w_ / 720;
    for (T before = t; before < last; before += step) {
      T after = std::min(before + step, last);
      if (drive_size(before) > m) return before;
      if (drive_size(after) <= m) continue;
      while (after - before > std::numeric_limits<T>::epsilon() * last * 4) {
        const T middle = (before + after) / 2;
        (drive_size(middle) > m ? after : before) = middle;
      }
      return after;
    }
    return last;
  }

  static T turn() { return 2 * std::numbers::pi_v<T>; }

 private:
  T w_, start_phase_, ax_, ay_cos_, ay_sin_, tilt_x_, tilt_y_, m1_, m2_, opens_, width_, end_;
};

/// What a tolerance means in a scene: relative to A (positions) and A w (velocities).
struct Scales {
  double length = 0, speed = 0;
  explicit Scales(const model::Scenario& s)
      : length(std::max(s.drive.amplitude, s.drive.amplitude_y)), speed(length * s.drive.angular_frequency) {}
};

/// Within some tolerances of zero an explicit method no longer knows the direction and chatters; below 1e-10
/// of A w the rest of the path is nothing, but its steps get lost against t.
inline double stop_speed(const Scales& scales, double tolerance) {
  return std::max(30 * tolerance, 1e-10) * scales.speed;
}

/// Where the run stands.
template <class T>
struct Progress {
  typename PlainEquation<T>::State q{};
  T t = 0;
  long steps = 0;
  long max_steps = 0;

  Progress(const model::Scenario& s, long most)
      : q{0, 0, T(s.initial_velocity.x()), T(s.initial_velocity.y())}, max_steps(most) {}
  bool within_budget() const { return steps < max_steps; }
  bool at_rest() const { return q[2] == 0 && q[3] == 0; }
  PeerResult result(T end) const {
    return {{static_cast<double>(q[0]), static_cast<double>(q[1])},
            {static_cast<double>(q[2]), static_cast<double>(q[3])},
            steps,
            t >= end};
  }
};

/// The witness of a stop after a step from state `before`: friction exceeds the drive, and the velocity has
/// turned round or is below stop_speed. Sets u = 0.
template <class T>
bool stops(const PlainEquation<T>& f, const typename PlainEquation<T>::State& before, T m, T stop_speed,
           Progress<T>& p) {
  const T turned = before[2] * p.q[2] + before[3] * p.q[3];
  if (turned > 0 && std::hypot(p.q[2], p.q[3]) > stop_speed) return false;
  if (f.drive_size(p.t) > m) return false;
  p.q[2] = p.q[3] = 0;
  return true;
}

/// slide(p, until, m) carries the sliding motion under constant friction m to `until` or to a stop.
template <class T, class Slide>
PeerResult run_in_segments(const PlainEquation<T>& f, Progress<T> p, Slide&& slide) {
  for (const T station : f.stations()) {
    // mu is constant in a segment: its value at the middle is free of rounding at the edges.
    const T m = f.friction((p.t + station) / 2);
    while (p.t < station && p.within_budget()) {
      if (p.at_rest()) p.t = f.release(p.t, station, m);
      if (p.t < station) slide(p, station, m);
    }
  }
  return p.result(f.end());
}

}  // namespace tribotrack::bench
