// A solved run behind Trajectory, for any number of derivatives.
#pragma once

#include <Eigen/LU>
#include <stdexcept>

#include "model/orbit/orbit.h"
#include "model/solver/set_up.h"
#include "model/trajectory.h"

namespace tribotrack::model {

struct Trajectory::Implementation {
  Implementation(const Scenario& s, const IntegrationOptions& o) : scenario(s), options(o) {}
  virtual ~Implementation() = default;
  /// With derivatives at a fixed time t, or else at a fixed phase w t of the platform.
  virtual SensitiveSample at(double time, bool fixed_time) const = 0;

  Scenario scenario;
  IntegrationOptions options;
  IntegrationSummary summary;
};

namespace internal {

template <class T>
class Run final : public Trajectory::Implementation {
 public:
  Run(const Scenario& s, const IntegrationOptions& o);
  SensitiveSample at(double time, bool fixed_time) const override;

 private:
  SolverInput<T> prepare() const;
  void start_on_orbit(SolverInput<T>& in, bool with_pulses) const;
  Phase phase_at(double time) const;
  bool is_end(const Phase& phase) const { return phase.cycles == input_.cycles && phase.rest == input_.rest; }
  Motion<T> motion_at(const Phase& phase) const;

  T w_;
  SolverInput<T> input_;
  Solver<T> solver_;
};

template <class T>
Run<T>::Run(const Scenario& s, const IntegrationOptions& o)
    : Implementation(s, o),
      w_(seeded<T>(s, Parameter::angular_frequency, o.derivatives)),
      input_(prepare()),
      solver_(input_) {
  solver_.run();
  const StepCounts& counts = solver_.counts();
  summary.steps = counts.steps;
  summary.stops = static_cast<int>(counts.stops);
  summary.releases = static_cast<int>(counts.releases);
  summary.stick_time = counts.stick_phase / s.drive.angular_frequency;
  const double phase = input_.cycles * kTwoPi + input_.rest;
  summary.sticking_fraction = phase > 0 ? counts.stick_phase / phase : 0;
}

template <class T>
SolverInput<T> Run<T>::prepare() const {
  SolverInput<T> in = set_up<T>(scenario, options.derivatives);
  in.tolerance = options.tolerance;
  in.max_steps = options.max_steps;
  in.dense = options.dense;
  in.reuse = options.reuse_repeating_cycles;
  if (scenario.start != Start::rest) start_on_orbit(in, scenario.start == Start::steady);
  return in;
}

/// U0 = P(U0, p) differentiated: dU0 = (I - dP/dU)^-1 dP/dp.
template <class T>
void Run<T>::start_on_orbit(SolverInput<T>& in, bool with_pulses) const {
  // The derivatives below are as good as the Jacobian, and cycles count as repeating only where they agree.
  const double jacobian_error = derivative_count < T >> 0 ? 1e-13 : 1.0;
  const auto orbit = find_orbit(scenario, with_pulses, options.tolerance, jacobian_error, options.max_steps);
  if (!orbit)
    throw InvalidParameter(
        std::string("start = ") + to_string(scenario.start) +
        ": no unique periodic motion exists for these parameters (no friction in the cycle, or "
        "tilt beyond the friction angle); use start = rest");
  in.velocity = {T(orbit->velocity.x()), T(orbit->velocity.y())};
  in.on_orbit = true;
  in.contraction = orbit->contraction();
  if constexpr (derivative_count < T >> 0) {
    Scenario free = scenario;
    free.start = Start::rest;
    SolverInput<T> cycle = set_up<T>(free, options.derivatives, with_pulses);
    cycle.problem = in.problem;
    cycle.velocity = in.velocity;
    cycle.start_shift = T{};
    cycle.tolerance = in.tolerance;
    cycle.max_steps = in.max_steps;
    cycle.cycles = 1;
    cycle.rest = 0;
    Solver<T> solver(cycle);
    solver.run();
    const Pair<T> end = solver.end().velocity;
    const Eigen::Matrix2d inverse = (Eigen::Matrix2d::Identity() - orbit->jacobian).inverse();
    for (int j = 0; j < derivative_count<T>; ++j) {
      const Eigen::Vector2d d = inverse * Eigen::Vector2d(end.x.d[j], end.y.d[j]);
      in.velocity.x.d[j] = d.x();
      in.velocity.y.d[j] = d.y();
    }
  }
}

template <class T>
Phase Run<T>::phase_at(double time) const {
  if (!(time > 0)) return {};
  Phase phase = reduce_product(scenario.drive.angular_frequency, time);
  const Phase end{input_.cycles, input_.rest};
  if (time >= scenario.end_time() || phase.cycles > end.cycles ||
      (phase.cycles == end.cycles && phase.rest > end.rest))
    return end;
  return phase;
}

template <class T>
Motion<T> Run<T>::motion_at(const Phase& phase) const {
  if (is_end(phase)) return solver_.end();
  if (!options.dense)
    throw std::logic_error("Trajectory: only the end is known of a run without IntegrationOptions::dense");
  return solver_.at(phase.cycles, phase.rest);
}

template <class T>
SensitiveSample Run<T>::at(double time, bool fixed_time) const {
  const Phase phase = phase_at(time);
  const Motion<T> m = motion_at(phase);
  const Contact contact = is_end(phase) ? solver_.end_contact() : solver_.contact(phase.cycles, phase.rest);
  const double unit = input_.problem.velocity_unit;
  Pair<T> acceleration{};
  if (!contact.sticks)
    acceleration = force(solver_.drive(), solver_.kappa(contact.reduced), phase.rest, m.velocity);

  SensitiveSample result;
  Sample& sample = result.sample;
  const double w = scenario.drive.angular_frequency;
  sample.time = time;
  sample.position = unit / w * Eigen::Vector2d(value(m.position.x), value(m.position.y));
  sample.velocity = unit * Eigen::Vector2d(value(m.velocity.x), value(m.velocity.y));
  sample.acceleration = unit * w * Eigen::Vector2d(value(acceleration.x), value(acceleration.y));
  if (input_.cycles > 0 || input_.rest > 0) {
    sample.mu = contact.reduced ? scenario.friction.reduced : scenario.friction.nominal;
    sample.state = contact.sticks ? State::stick : State::slip;
  }

  const auto columns = static_cast<Eigen::Index>(options.derivatives.size());
  result.position_jacobian.setZero(2, columns);
  result.velocity_jacobian.setZero(2, columns);
  if constexpr (derivative_count < T >> 0) {
    // From fixed phase s to fixed time: s = start phase + w t depends on the parameters.
    T moved = input_.start_shift;
    if (fixed_time) moved += change(w_) * time;
    const Pair<T> x = T(unit / w_) * (m.position + moved * m.velocity);
    const Pair<T> u = T(unit) * (m.velocity + moved * acceleration);
    for (int j = 0; j < columns; ++j) {
      result.position_jacobian.col(j) << x.x.d[j], x.y.d[j];
      result.velocity_jacobian.col(j) << u.x.d[j], u.y.d[j];
    }
  }
  return result;
}

}  // namespace internal
}  // namespace tribotrack::model
