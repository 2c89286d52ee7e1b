// From a Scenario to the solver's units, with the chosen derivatives.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/scenario.h"
#include "model/solver/solver.h"

namespace tribotrack::model::internal {

/// The parameter's value, with derivative 1 in its own column.
template <class T>
T seeded(const Scenario& scenario, Parameter parameter, const std::vector<Parameter>& columns) {
  T t(scenario.get(parameter));
  if constexpr (derivative_count < T >> 0)
    for (size_t j = 0; j < columns.size(); ++j)
      if (columns[j] == parameter) t.d[j] = 1;
  return t;
}

/// A power of two near (a + mu g)/w.
inline double velocity_unit(const Scenario& s) {
  const Drive& d = s.drive;
  const double w = d.angular_frequency;
  const double bound =
      std::max({d.amplitude * w, d.amplitude_y * w, d.gravity * std::fabs(std::sin(d.tilt_x)) / w,
                d.gravity * std::fabs(std::sin(d.tilt_y)) / w, s.friction.nominal * d.gravity / w,
                s.friction.reduced * d.gravity / w});
  const double unit = bound > 0 ? bound : s.initial_velocity.norm();
  return unit > 0 ? std::exp2(std::round(std::log2(unit))) : 1.0;
}

/// What the solver needs apart from the velocity on an orbit. cos(wt + epsilon) is expanded so that huge
/// start phases lose nothing.
template <class T>
SolverInput<T> set_up(const Scenario& s, const std::vector<Parameter>& columns, bool with_pulses = true) {
  using std::cos;
  using std::sin;
  const auto of = [&](Parameter p) { return seeded<T>(s, p, columns); };
  SolverInput<T> in;
  const double unit = velocity_unit(s);
  in.problem.velocity_unit = unit;
  const T w = of(Parameter::angular_frequency), g = of(Parameter::gravity);
  const T ax = of(Parameter::amplitude) * w / unit, ay = of(Parameter::amplitude_y) * w / unit;
  const T epsilon = of(Parameter::phase_shift), ce = cos(epsilon), se = sin(epsilon);
  const double c = std::cos(s.start_phase), k = std::sin(s.start_phase);
  const T per_w = g / w / unit;
  in.problem.drive = {{per_w * sin(of(Parameter::tilt_x)), per_w * sin(of(Parameter::tilt_y))},
                      {ax * c, ay * (ce * c - se * k)},
                      {ax * -k, ay * (ce * -k - se * c)}};
  in.problem.kappa_nominal = of(Parameter::mu1) * per_w;
  in.problem.kappa_reduced = of(Parameter::mu2) * per_w;
  if (with_pulses)
    in.edges = pulse_edges(of(Parameter::phi), of(Parameter::lag), of(Parameter::dtau), s.start_phase);
  in.velocity = {of(Parameter::velocity_x) / unit, of(Parameter::velocity_y) / unit};
  in.start_shift = change(of(Parameter::start_phase));
  in.circling = s.start == Start::circling;
  if (s.duration > 0) {
    const Phase end = reduce_product(s.drive.angular_frequency, s.duration);
    in.cycles = end.cycles;
    in.rest = end.rest;
  } else {
    in.cycles = std::floor(s.cycles);
    in.rest = (s.cycles - in.cycles) * kTwoPi;
  }
  return in;
}

}  // namespace tribotrack::model::internal
