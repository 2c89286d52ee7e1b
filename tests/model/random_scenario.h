// Random scenarios for tests, reproducible from a printed seed.
#pragma once

#include <numbers>
#include <random>

#include "model/scenario.h"

namespace tribotrack::model {

class RandomScenario {
 public:
  explicit RandomScenario(unsigned seed) : generator_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<>(low, high)(generator_); }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }

  /// Circular drive, both frictions below or above the drive's amplitude.
  Scenario circular() {
    Scenario s;
    s.drive.angular_frequency = log_uniform(5, 500);
    s.drive.amplitude = s.drive.amplitude_y = log_uniform(1e-5, 1e-2);
    const double a = s.drive.amplitude * s.drive.angular_frequency * s.drive.angular_frequency;
    s.friction.nominal = uniform(0.1, 2.5) * a / s.drive.gravity;
    s.friction.reduced = s.friction.nominal * uniform(0, 1);
    s.friction.phase = uniform(-7, 7);
    s.friction.lag = uniform(-1, 1);
    s.friction.pulse_width = uniform(0, 2 * std::numbers::pi);
    s.start_phase = uniform(-4, 4);
    s.cycles = 2;
    return s;
  }
  /// Any ellipse, tilt and initial velocity.
  Scenario general() {
    Scenario s = circular();
    s.drive.amplitude_y = s.drive.amplitude * uniform(0.3, 1.5);
    s.drive.phase_shift = uniform(-3.1, 3.1);
    const double a = s.drive.amplitude * s.drive.angular_frequency * s.drive.angular_frequency;
    if (uniform(0, 1) < 0.5) {
      s.drive.tilt_x = std::atan(0.3 * uniform(-1, 1) * a / s.drive.gravity);
      s.drive.tilt_y = std::atan(0.3 * uniform(-1, 1) * a / s.drive.gravity);
    }
    if (uniform(0, 1) < 0.5) {
      const double speed = a / s.drive.angular_frequency;
      s.initial_velocity = {speed * uniform(-1, 1), speed * uniform(-1, 1)};
    }
    return s;
  }

 private:
  std::mt19937 generator_;
};

}  // namespace tribotrack::model
