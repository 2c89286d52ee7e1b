// A solved run of a part that slides on the resting platform, spins or feels viscous friction, behind
// Trajectory.
#pragma once

#include <Eigen/Core>
#include <string>

#include "model/run/solved_run.h"
#include "model/spin/spinning_slide.h"

namespace tribotrack::model::internal {

template <class T>
class SpinRun final : public Trajectory::Implementation {
 public:
  SpinRun(const Scenario& s, const IntegrationOptions& o)
      : Implementation(s, o), slide_(equation(), start(), s.end_time(), o.tolerance, o.max_steps) {
    if (!slide_.complete())
      throw StepLimitExceeded("the spinning slide takes more than max_steps = " +
                              std::to_string(o.max_steps) + " steps to follow");
    summary.steps = static_cast<long>(slide_.steps());
    if (!slide_.stopped()) return;
    summary.stops = 1;
    summary.stick_time = s.end_time() - slide_.stop_time();
    summary.sticking_fraction = s.end_time() > 0 ? summary.stick_time / s.end_time() : 0;
  }

  SensitiveSample at(double time, bool) const override {
    const State state = slide_.at(time);
    const Pair<T> acceleration = slide_.acceleration(state);
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
  using State = SpinState<T>;

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
  SpinningSlide<T> slide_;
};

}  // namespace tribotrack::model::internal
