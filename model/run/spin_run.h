// A disc that slides and spins on the resting platform, from its start to its stop, behind Trajectory.
//
//   u' = d - (mu g drag + c) u,   w' = -(mu g brake + c/2) w/k,   theta' = w/R
// with w = omega R, k = I/(m R^2) (1/2 for an even disc), d the in-plane gravity of a tilt, c the viscous
// part of friction (its moment over an even face is half of its force's), and drag, brake of disc_friction.h.
// Sliding and spinning end together (with k = 1/2 and no tilt at u/w = 0.653), and on the way there the
// velocities fall in a straight line: steps in proportion to the speed left meet the stop as a geometric
// series. Steps are Dormand and Prince's fifth order (J. Comput. Appl. Math. 6, 19, 1980).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "model/run/solved_run.h"
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
class SpinRun final : public Trajectory::Implementation {
  using State = SpinState<T>;

 public:
  SpinRun(const Scenario& s, const IntegrationOptions& o)
      : Implementation(s, o), equation_(equation()), tolerance_(std::max(o.tolerance, kFinest)) {
    const double end_time = s.end_time();
    steps_.push_back({0, start()});
    const double rest = kAtRest * steps_.front().state.speed();
    double try_next = end_time;
    while (steps_.back().time < end_time && static_cast<long>(steps_.size()) <= o.max_steps) {
      const auto [time, state] = steps_.back();
      const double speed = state.speed();
      if (!(speed > rest)) {
        // On a slope too weak to start it again; otherwise it comes loose at once along the slope.
        if (equation_.stops() || !(speed > 0)) {
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
    if (!stopped_ && steps_.back().time < end_time)
      throw StepLimitExceeded("the spinning slide takes more than max_steps = " +
                              std::to_string(o.max_steps) + " steps to follow");
    summary.steps = static_cast<long>(steps_.size()) - 1;
    if (!stopped_) return;
    summary.stops = 1;
    summary.stick_time = end_time - steps_.back().time;
    summary.sticking_fraction = end_time > 0 ? summary.stick_time / end_time : 0;
  }

  SensitiveSample at(double time, bool) const override {
    const State state = state_at(time);
    const Pair<T> acceleration = acceleration_at(state);
    SensitiveSample result;
    Sample& sample = result.sample;
    sample.time = time;
    sample.position = {value(state.of[State::x]), value(state.of[State::y])};
    sample.velocity = {value(state.of[State::ux]), value(state.of[State::uy])};
    sample.acceleration = {value(acceleration.x), value(acceleration.y)};
    sample.angle = value(state.of[State::rim]) * per_radius();
    sample.spin = value(state.of[State::w]) * per_radius();
    sample.mu = scenario.friction.nominal;
    sample.state = state.speed() > 0 ? model::State::slip : model::State::stick;
    const auto columns = static_cast<Eigen::Index>(options.derivatives.size());
    result.position_jacobian.setZero(2, columns);
    result.velocity_jacobian.setZero(2, columns);
    result.angle_jacobian.setZero(columns);
    if constexpr (derivative_count < T >> 0)
      for (Eigen::Index j = 0; j < columns; ++j) {
        const auto d = static_cast<std::size_t>(j);
        result.position_jacobian.col(j) << state.of[State::x].d[d], state.of[State::y].d[d];
        result.velocity_jacobian.col(j) << state.of[State::ux].d[d], state.of[State::uy].d[d];
        result.angle_jacobian(j) = state.of[State::rim].d[d] * per_radius();
      }
    return result;
  }

 private:
  /// Share of the time to the stop that a step covers at most; halving it changes no digit printed.
  static constexpr double kShare = 0.25;
  /// Speed over the first one at which the disc rests: the way left is its square of the way gone.
  static constexpr double kAtRest = 1e-9;
  static constexpr double kFinest = 1e-13;

  struct Step {
    double time;
    State state;
  };
  struct Attempt {
    State state;
    double error;
  };

  double per_radius() const { return scenario.spin.radius > 0 ? 1 / scenario.spin.radius : 0; }
  T seed(Parameter parameter) const { return seeded<T>(scenario, parameter, options.derivatives); }
  SpinEquation<T> equation() const {
    using std::sin;
    const T g = seed(Parameter::gravity);
    return {seed(Parameter::mu1) * g,
            {g * sin(seed(Parameter::tilt_x)), g * sin(seed(Parameter::tilt_y))},
            seed(Parameter::inertia),
            seed(Parameter::viscous)};
  }
  State start() const {
    State state;
    state.of[State::ux] = seed(Parameter::velocity_x);
    state.of[State::uy] = seed(Parameter::velocity_y);
    state.of[State::w] = seed(Parameter::spin) * scenario.spin.radius;
    return state;
  }

  /// After the stop: the last state, its velocities 0.
  State state_at(double time) const {
    if (stopped_ && time >= steps_.back().time) {
      State state = steps_.back().state;
      for (const auto k : {State::ux, State::uy, State::w}) state.of[k] = T(0.0);
      return state;
    }
    const auto next = std::upper_bound(steps_.begin(), steps_.end(), time,
                                       [](double t, const Step& step) { return t < step.time; });
    const Step& from = next == steps_.begin() ? steps_.front() : *(next - 1);
    return time > from.time ? advance(from.state, time - from.time).state : from.state;
  }
  /// x'' at a state of the motion.
  Pair<T> acceleration_at(const State& state) const {
    if (!(state.speed() > 0)) return {};
    const State slope = equation_.slope(state);
    return {slope.of[State::ux], slope.of[State::uy]};
  }

  Attempt advance(const State& s, double h) const {
    static constexpr double a[6][6] = {
        {1.0 / 5},
        {3.0 / 40, 9.0 / 40},
        {44.0 / 45, -56.0 / 15, 32.0 / 9},
        {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
        {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
        {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
    static constexpr double e[7] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                    -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
    std::array<State, 7> k;
    k[0] = equation_.slope(s);
    State next;
    for (std::size_t stage = 0; stage < 6; ++stage) {
      next = s;
      for (std::size_t j = 0; j <= stage; ++j)
        for (std::size_t i = 0; i < State::count; ++i) add_multiple(next.of[i], h * a[stage][j], k[j].of[i]);
      k[stage + 1] = equation_.slope(next);
    }
    double square = 0;
    for (const std::size_t i : {State::ux, State::uy, State::w}) {
      double error = 0;
      for (std::size_t j = 0; j < 7; ++j) error += h * e[j] * value(k[j].of[i]);
      square += error * error;
    }
    return {next, std::sqrt(square)};
  }

  SpinEquation<T> equation_;
  double tolerance_;
  std::vector<Step> steps_;
  bool stopped_ = false;  ///< at the last step
};

}  // namespace tribotrack::model::internal
