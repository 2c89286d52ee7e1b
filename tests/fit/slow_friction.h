// An independent, slow and obviously right solution of eq. (5): classical Runge-Kutta with steps that never
// cross a friction switch, stick decided at every step. Shares nothing with the library's integrator.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::test {

struct SlowPoint {
  double time;
  Eigen::Vector2d position, velocity;
};

class SlowFriction {
 public:
  explicit SlowFriction(const model::Scenario& scenario) : s_(scenario) {}

  /// States at the given increasing times, from rest or from the initial velocity at time 0.
  std::vector<SlowPoint> at(const std::vector<double>& times, int steps_per_cycle = 4000) const {
    std::vector<SlowPoint> result;
    SlowPoint state{0, Eigen::Vector2d::Zero(), s_.initial_velocity};
    const double w = s_.drive.angular_frequency;
    const double longest = 2 * std::numbers::pi / w / steps_per_cycle;
    for (const double time : times) {
      while (state.time < time - 1e-15) {
        const double switch_time = next_switch(state.time);
        const double h = std::min({longest, time - state.time, switch_time - state.time});
        const double mu = mu_at(state.time + 0.5 * h);
        advance(state, h, mu);
      }
      result.push_back({time, state.position, state.velocity});
    }
    return result;
  }

  Eigen::Vector2d displacement(int steps_per_cycle = 4000) const {
    const double end =
        s_.duration > 0 ? s_.duration : s_.cycles * 2 * std::numbers::pi / s_.drive.angular_frequency;
    return at({end}, steps_per_cycle).back().position;
  }

 private:
  double mu_at(double time) const {
    const double turn = 2 * std::numbers::pi;
    double into = std::fmod(
        s_.start_phase + s_.drive.angular_frequency * time - s_.friction.phase - s_.friction.lag, turn);
    if (into < 0) into += turn;
    return into < s_.friction.pulse_width ? s_.friction.reduced : s_.friction.nominal;
  }
  double next_switch(double time) const {
    const double turn = 2 * std::numbers::pi;
    double next = 1e300;
    for (const double edge : {0.0, s_.friction.pulse_width}) {
      const double offset = s_.friction.phase + s_.friction.lag + edge - s_.start_phase;
      const double n = std::floor((s_.drive.angular_frequency * time - offset) / turn + 1e-12) + 1;
      next = std::min(next, (offset + n * turn) / s_.drive.angular_frequency);
    }
    return next <= time ? time + 1e-9 : next;
  }
  Eigen::Vector2d drive(double time) const {
    const double w = s_.drive.angular_frequency, phase = s_.start_phase + w * time;
    return {s_.drive.amplitude * w * w * std::cos(phase) + s_.drive.gravity * std::sin(s_.drive.tilt_x),
            s_.drive.amplitude_y * w * w * std::cos(phase + s_.drive.phase_shift) +
                s_.drive.gravity * std::sin(s_.drive.tilt_y)};
  }
  Eigen::Vector2d acceleration(double time, const Eigen::Vector2d& u, double mu) const {
    const double m = mu * s_.drive.gravity;
    const Eigen::Vector2d d = drive(time);
    if (u.norm() > 0) return d - m * u.normalized();
    return d.norm() > m ? Eigen::Vector2d(d - m * d.normalized()) : Eigen::Vector2d(0, 0);
  }
  void runge_kutta(SlowPoint& state, double h, double mu) const {
    const double t = state.time;
    const Eigen::Vector2d u = state.velocity;
    const Eigen::Vector2d k1 = acceleration(t, u, mu);
    const Eigen::Vector2d k2 = acceleration(t + h / 2, u + h / 2 * k1, mu);
    const Eigen::Vector2d k3 = acceleration(t + h / 2, u + h / 2 * k2, mu);
    const Eigen::Vector2d k4 = acceleration(t + h, u + h * k3, mu);
    state.position += h * u + h * h / 6 * (k1 + k2 + k3);
    state.velocity += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    state.time += h;
  }
  void advance(SlowPoint& state, double h, double mu) const {
    const double m = mu * s_.drive.gravity;
    if (state.velocity.norm() == 0 && drive(state.time + h / 2).norm() <= m) {
      state.time += h;
      return;
    }
    // The direction turns over a time |u|/m: while that is short, steps are short, too.
    const double end = state.time + h;
    while (state.time < end) {
      const double left = end - state.time;
      const double speed = state.velocity.norm();
      if (speed > 0 && speed < 1e-12 && drive(state.time).norm() <= m) {
        state.velocity.setZero();
        state.time = end;
        return;
      }
      double step = left;
      if (m > 0 && speed > 0) step = std::min(left, std::max(0.02 * speed / m, 1e-13));
      if (speed == 0) step = std::min(left, 1e-3 * left + 1e-13);
      if (left - step < 1e-15) step = left;
      runge_kutta(state, step, mu);
      if (step == left) {
        state.time = end;
        return;
      }
    }
  }

  model::Scenario s_;
};

}  // namespace tribotrack::test
