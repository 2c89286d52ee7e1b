#include "model/scenario.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "model/equation/phase.h"

namespace tribotrack::model {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// Name and place of every Parameter, in the order of the enumeration.
auto parameters_of(auto& s) {
  using Named = std::pair<const char*, decltype(&s.start_phase)>;
  return std::array{Named{"mu1", &s.friction.nominal},
                    Named{"mu2", &s.friction.reduced},
                    Named{"lag_rad", &s.friction.lag},
                    Named{"phi_rad", &s.friction.phase},
                    Named{"dtau_rad", &s.friction.pulse_width},
                    Named{"amplitude_m", &s.drive.amplitude},
                    Named{"amplitude_y_m", &s.drive.amplitude_y},
                    Named{"angular_frequency_rad_s", &s.drive.angular_frequency},
                    Named{"phase_shift_rad", &s.drive.phase_shift},
                    Named{"gravity_m_s2", &s.drive.gravity},
                    Named{"tilt_x_rad", &s.drive.tilt_x},
                    Named{"tilt_y_rad", &s.drive.tilt_y},
                    Named{"velocity_x_m_s", &s.initial_velocity.x()},
                    Named{"velocity_y_m_s", &s.initial_velocity.y()},
                    Named{"start_phase_rad", &s.start_phase},
                    Named{"spin_rad_s", &s.spin.rate},
                    Named{"inertia", &s.spin.inertia},
                    Named{"viscous_1_s", &s.viscous}};
}

auto named(auto& s, Parameter parameter) {
  return parameters_of(s).at(static_cast<std::size_t>(parameter));
}

[[noreturn]] void refuse(const char* name, double value, const char* range) {
  char number[40];
  std::snprintf(number, sizeof number, "%.10g", value);
  throw InvalidParameter(std::string(name) + " = " + number + " is out of range: it must be " + range);
}

}  // namespace

const char* to_string(Parameter parameter) {
  static const Scenario any;
  return named(any, parameter).first;
}

const char* to_string(Start start) {
  return std::array{"rest", "circling", "steady"}.at(static_cast<std::size_t>(start));
}

double Scenario::get(Parameter parameter) const {
  return *named(*this, parameter).second;
}
void Scenario::set(Parameter parameter, double value) {
  *named(*this, parameter).second = value;
}

double Scenario::end_time() const {
  return duration > 0 ? duration : cycles * (kTwoPi / drive.angular_frequency);
}

void Scenario::validate() const {
  for (const auto& [name, value] : parameters_of(*this))
    if (!std::isfinite(*value)) refuse(name, *value, "a finite number");
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
  const bool slides = drive.amplitude == 0 && drive.amplitude_y == 0 && start == Start::rest &&
                      friction.pulse_width * (friction.nominal - friction.reduced) == 0;
  require(viscous == 0 || slides, "viscous_1_s", viscous,
          "0 on a moving platform or with pulses: it is part of free slides only");
  if (spin.rate == 0) return;
  require(spin.radius > 0, "radius", spin.radius, "> 0 for a part that spins (m)");
  require(slides, "spin_rad_s", spin.rate,
          "0 on a moving platform or with pulses: spin is part of free slides only");
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
