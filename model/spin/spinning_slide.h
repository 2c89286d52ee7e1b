// A disc that slides and spins on the resting platform, from its start to its stop.
//
//   u' = d - (mu g drag + c) u,   w' = -(mu g brake + c/2) w/k,   theta' = w/R
// with w = omega R, k = I/(m R^2) (1/2 for an even disc), d the in-plane gravity of a tilt, c the viscous
// part of friction (its moment over an even face is half of its force's), and drag, brake of disc_friction.h.
// Sliding and spinning end together (with k = 1/2 and no tilt at u/w = 0.653), and on the way there the
// velocities fall in a straight line: steps in proportion to the speed left meet the stop as a geometric
// series. Steps are Dormand and Prince's fifth order (J. Comput. Appl. Math. 6, 19, 1980).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "model/spin/disc_friction.h"

namespace tribotrack::model::internal {

template <class T>
struct SpinState {
  enum : std::size_t { x, y, ux, uy, w, rim, count };  ///< rim: theta R
  std::array<T, count> of{};
  double speed() const { return std::hypot(value(of[ux]), value(of[uy]), value(of[w])); }
};

template <class T>
struct SpinEquation {
  T mu_g;
  Pair<T> tilt;    ///< d, m/s^2
  T inertia{0.5};  ///< k
  T viscous{0.0};  ///< c

  SpinState<T> slope(const SpinState<T>& s) const {
    using S = SpinState<T>;
    const T &ux = s.of[S::ux], &uy = s.of[S::uy], &w = s.of[S::w];
    const Braking<T> by = braking<T>(ux * ux + uy * uy, w * w);
    const T drag = mu_g * by.drag + viscous;
    const T brake = mu_g * by.brake + 0.5 * viscous;
    return {{ux, uy, tilt.x - drag * ux, tilt.y - drag * uy, -1.0 * (brake * w / inertia), w}};
  }
  double tilt_size() const { return length(tilt); }
  /// The velocities change no faster than this at a speed, m/s^2.
  double fastest(double speed) const {
    return (value(mu_g) + std::abs(value(viscous)) * speed) / std::sqrt(value(inertia)) + tilt_size();
  }
  bool stops() const { return value(mu_g) > tilt_size(); }
};

/// The motion step by step; sampled by a shorter step from the last grid point before.
template <class T>
class SpinningSlide {
 public:
  SpinningSlide(const SpinEquation<T>& equation, const SpinState<T>& start, double end_time, double tolerance,
                long max_steps)
      : equation_(equation), tolerance_(std::max(tolerance, kFinest)) {
    const double rest = kAtRest * start.speed();
    steps_.push_back({0, start});
    double try_next = end_time;
    while (steps_.back().time < end_time && static_cast<long>(steps_.size()) <= max_steps) {
      const auto [time, state] = steps_.back();
      const double speed = state.speed();
      if (!(speed > rest)) {
        // On a slope too weak to start it again; otherwise it comes loose at once along the slope.
        if (equation_.stops() || !(speed > 0)) {
          stop_time_ = time;
          stopped_ = true;
          break;
        }
      }
      const double longest = kShare * speed / equation_.fastest(speed);
      double step = std::min({try_next, longest, end_time - time});
      Attempt attempt = advance(state, step);
      while (attempt.error > tolerance_ * speed && step > 1e-12 * longest) {
        step *= std::max(0.2, 0.9 * std::pow(tolerance_ * speed / attempt.error, 0.2));
        attempt = advance(state, step);
      }
      const double ratio = attempt.error > 0 ? tolerance_ * speed / attempt.error : 1e5;
      try_next = step * std::min(4.0, 0.9 * std::pow(ratio, 0.2));
      const bool last = end_time - time - step <= 1e-15 * end_time;
      steps_.push_back({last ? end_time : time + step, attempt.state});
    }
    complete_ = stopped_ || steps_.back().time >= end_time;
  }

  bool complete() const { return complete_; }
  bool stopped() const { return stopped_; }
  double stop_time() const { return stop_time_; }
  std::size_t steps() const { return steps_.size() - 1; }
  /// After the stop: the last state, its velocities 0.
  SpinState<T> at(double time) const {
    using S = SpinState<T>;
    if (stopped_ && time >= stop_time_) {
      S state = steps_.back().state;
      for (const auto k : {S::ux, S::uy, S::w}) state.of[k] = T(0.0);
      return state;
    }
    const auto next = std::upper_bound(steps_.begin(), steps_.end(), time,
                                       [](double t, const Step& step) { return t < step.time; });
    const Step& from = next == steps_.begin() ? steps_.front() : *(next - 1);
    return time > from.time ? advance(from.state, time - from.time).state : from.state;
  }
  /// x'' at a state of the motion.
  Pair<T> acceleration(const SpinState<T>& state) const {
    using S = SpinState<T>;
    if (!(state.speed() > 0)) return {};
    const S slope = equation_.slope(state);
    return {slope.of[S::ux], slope.of[S::uy]};
  }

 private:
  /// Share of the time to the stop that a step covers at most; halving it changes no digit printed.
  static constexpr double kShare = 0.25;
  /// Speed over the first one at which the disc rests: the way left is its square of the way gone.
  static constexpr double kAtRest = 1e-9;
  static constexpr double kFinest = 1e-13;

  struct Step {
    double time;
    SpinState<T> state;
  };
  struct Attempt {
    SpinState<T> state;
    double error;
  };

  Attempt advance(const SpinState<T>& s, double h) const {
    static constexpr double a[6][6] = {
        {1.0 / 5},
        {3.0 / 40, 9.0 / 40},
        {44.0 / 45, -56.0 / 15, 32.0 / 9},
        {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
        {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
        {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
    static constexpr double e[7] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                    -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
    std::array<SpinState<T>, 7> k;
    k[0] = equation_.slope(s);
    SpinState<T> next;
    for (std::size_t stage = 0; stage < 6; ++stage) {
      next = s;
      for (std::size_t j = 0; j <= stage; ++j)
        for (std::size_t i = 0; i < SpinState<T>::count; ++i)
          add_multiple(next.of[i], h * a[stage][j], k[j].of[i]);
      k[stage + 1] = equation_.slope(next);
    }
    double square = 0;
    for (const std::size_t i : {SpinState<T>::ux, SpinState<T>::uy, SpinState<T>::w}) {
      double error = 0;
      for (std::size_t j = 0; j < 7; ++j) error += h * e[j] * value(k[j].of[i]);
      square += error * error;
    }
    return {next, std::sqrt(square)};
  }

  SpinEquation<T> equation_;
  double tolerance_;
  std::vector<Step> steps_;
  double stop_time_ = 0;
  bool stopped_ = false, complete_ = false;
};

}  // namespace tribotrack::model::internal
