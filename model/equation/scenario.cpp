#include "model/scenario.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "model/drive.h"
#include "model/equation/phase.h"
#include "model/friction.h"

namespace tribotrack::model {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

constexpr std::array kParameters = {
    Parameter::mu1,         Parameter::mu2,        Parameter::lag,         Parameter::phi,
    Parameter::dtau,        Parameter::amplitude,  Parameter::amplitude_y, Parameter::angular_frequency,
    Parameter::phase_shift, Parameter::gravity,    Parameter::tilt_x,      Parameter::tilt_y,
    Parameter::velocity_x,  Parameter::velocity_y, Parameter::start_phase, Parameter::spin,
    Parameter::inertia,
};

template <class Scenario_>
auto& reference(Scenario_& s, Parameter parameter) {
  switch (parameter) {
    case Parameter::mu1:
      return s.friction.nominal;
    case Parameter::mu2:
      return s.friction.reduced;
    case Parameter::lag:
      return s.friction.lag;
    case Parameter::phi:
      return s.friction.phase;
    case Parameter::dtau:
      return s.friction.pulse_width;
    case Parameter::amplitude:
      return s.drive.amplitude;
    case Parameter::amplitude_y:
      return s.drive.amplitude_y;
    case Parameter::angular_frequency:
      return s.drive.angular_frequency;
    case Parameter::phase_shift:
      return s.drive.phase_shift;
    case Parameter::gravity:
      return s.drive.gravity;
    case Parameter::tilt_x:
      return s.drive.tilt_x;
    case Parameter::tilt_y:
      return s.drive.tilt_y;
    case Parameter::velocity_x:
      return s.initial_velocity.x();
    case Parameter::velocity_y:
      return s.initial_velocity.y();
    case Parameter::start_phase:
      return s.start_phase;
    case Parameter::spin:
      return s.spin.rate;
    case Parameter::inertia:
      return s.spin.inertia;
  }
  throw InvalidParameter("unknown model parameter");
}

[[noreturn]] void refuse(const char* name, double value, const char* range) {
  char number[40];
  std::snprintf(number, sizeof number, "%.10g", value);
  throw InvalidParameter(std::string(name) + " = " + number + " is out of range: it must be " + range);
}

}  // namespace

const char* to_string(Parameter parameter) {
  switch (parameter) {
    case Parameter::mu1:
      return "mu1";
    case Parameter::mu2:
      return "mu2";
    case Parameter::lag:
      return "lag_rad";
    case Parameter::phi:
      return "phi_rad";
    case Parameter::dtau:
      return "dtau_rad";
    case Parameter::amplitude:
      return "amplitude_m";
    case Parameter::amplitude_y:
      return "amplitude_y_m";
    case Parameter::angular_frequency:
      return "angular_frequency_rad_s";
    case Parameter::phase_shift:
      return "phase_shift_rad";
    case Parameter::gravity:
      return "gravity_m_s2";
    case Parameter::tilt_x:
      return "tilt_x_rad";
    case Parameter::tilt_y:
      return "tilt_y_rad";
    case Parameter::velocity_x:
      return "velocity_x_m_s";
    case Parameter::velocity_y:
      return "velocity_y_m_s";
    case Parameter::start_phase:
      return "start_phase_rad";
    case Parameter::spin:
      return "spin_rad_s";
    case Parameter::inertia:
      return "inertia";
  }
  return "?";
}

const char* to_string(Start start) {
  switch (start) {
    case Start::rest:
      return "rest";
    case Start::circling:
      return "circling";
    case Start::steady:
      return "steady";
  }
  return "?";
}

double Scenario::get(Parameter parameter) const {
  return reference(*this, parameter);
}
void Scenario::set(Parameter parameter, double value) {
  reference(*this, parameter) = value;
}

double Scenario::end_time() const {
  return duration > 0 ? duration : cycles * (kTwoPi / drive.angular_frequency);
}

void Scenario::validate() const {
  for (const Parameter parameter : kParameters)
    if (!std::isfinite(get(parameter))) refuse(to_string(parameter), get(parameter), "a finite number");
  const auto require = [](bool good, const char* name, double value, const char* range) {
    if (!good) refuse(name, value, range);
  };
  require(friction.nominal >= 0, "mu1", friction.nominal, ">= 0");
  require(friction.reduced >= 0, "mu2", friction.reduced, ">= 0");
  require(friction.pulse_width >= 0 && friction.pulse_width <= kTwoPi, "dtau_rad", friction.pulse_width,
          "in [0, 2 pi]");
  require(drive.amplitude >= 0, "amplitude_m", drive.amplitude, ">= 0");
  require(drive.amplitude_y >= 0, "amplitude_y_m", drive.amplitude_y, ">= 0");
  require(drive.angular_frequency > 0, "angular_frequency_rad_s", drive.angular_frequency, "> 0");
  require(drive.gravity > 0, "gravity_m_s2", drive.gravity, "> 0");
  require(std::isfinite(duration) && duration >= 0, "duration", duration, ">= 0 and finite (s)");
  require(std::isfinite(cycles) && cycles >= 0, "cycles", cycles, ">= 0 and finite");
  require(start == Start::rest || start == Start::circling || start == Start::steady, "start",
          static_cast<double>(start), "rest, circling or steady");
  require(std::isfinite(spin.radius) && spin.radius >= 0, "radius", spin.radius, ">= 0 and finite (m)");
  require(std::isfinite(spin.inertia) && spin.inertia > 0, "inertia", spin.inertia, "> 0 and finite");
  if (spin.rate == 0) return;
  require(spin.radius > 0, "radius", spin.radius, "> 0 for a part that spins (m)");
  require(drive.amplitude == 0 && drive.amplitude_y == 0 && start == Start::rest &&
              friction.pulse_width * (friction.nominal - friction.reduced) == 0,
          "spin_rad_s", spin.rate, "0 on a moving platform or with pulses: spin is part of free slides only");
}

Eigen::Vector2d Drive::acceleration(double wt) const {
  const double square = angular_frequency * angular_frequency;
  return Eigen::Vector2d(square * amplitude * std::cos(wt) + gravity * std::sin(tilt_x),
                         square * amplitude_y * std::cos(wt + phase_shift) + gravity * std::sin(tilt_y));
}

Eigen::Vector2d Drive::displacement(double wt) const {
  return Eigen::Vector2d(amplitude * std::cos(wt), amplitude_y * std::cos(wt + phase_shift));
}

double Friction::coefficient(double wt) const {
  using internal::reduce;
  const double since_opening = reduce(reduce(wt).rest - reduce(phase).rest - reduce(lag).rest).rest;
  return since_opening < pulse_width ? reduced : nominal;
}

double gate_share(const Friction& friction, double from, double to) {
  constexpr double cycle = 2 * std::numbers::pi;
  // Time on since wt = phi, as a function of wt: whole pulses plus the part of the last one.
  const auto on_since = [&](double wt) {
    const double since = wt - friction.phase;
    const double whole = std::floor(since / cycle);
    return whole * friction.pulse_width + std::min(since - whole * cycle, friction.pulse_width);
  };
  // Rounding must not make a gate that is always on more than that.
  return std::clamp((on_since(to) - on_since(from)) / (to - from), 0.0, 1.0);
}

}  // namespace tribotrack::model
