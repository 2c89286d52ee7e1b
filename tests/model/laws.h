// The laws of model/trajectory.h: statements that every integrator of the friction model must obey exactly,
// each a function that applies itself to one scenario.
#pragma once

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "model/alpha_v.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::model::laws {

constexpr double kPi = std::numbers::pi;

/// Ordinary: slides throughout.
inline Scenario reference_run() {
  Scenario s;
  s.friction = {0.1, 0.0125, 0.5, kPi / 2, 0};
  return s;
}

inline double drive_amplitude(const Scenario& s) {
  return s.drive.amplitude * s.drive.angular_frequency * s.drive.angular_frequency;
}

/// The parts of a run that can be looked at: of one that is not dense the end alone.
inline std::vector<double> looked_at(const IntegrationOptions& how, const std::vector<double>& parts) {
  return how.dense ? parts : std::vector<double>{1.0};
}

/// Constant mu < a/g, circular drive: |u| = U = sqrt(a^2 - m^2)/w, the velocity lags the drive by d0, cos d0
/// = m/a.
inline void steady_sliding(Scenario s, double tolerance, const IntegrationOptions& how = {}) {
  s.friction.pulse_width = 0;
  s.start = Start::circling;
  s.cycles = 3.3;
  const double a = drive_amplitude(s), m = s.friction.nominal * s.drive.gravity,
               w = s.drive.angular_frequency;
  const double speed = std::sqrt((a - m) * (a + m)) / w;
  const Trajectory t = integrate(s, how);
  for (const double part : looked_at(how, {0.0, 0.1, 0.45, 0.8, 1.0})) {
    const double time = part * t.end_time();
    const Eigen::Vector2d u = t.at(time).velocity, d = s.drive.acceleration(s.start_phase + w * time);
    EXPECT_NEAR(u.norm(), speed, tolerance * speed) << "|u| at " << time;
    EXPECT_NEAR(u.dot(d), u.norm() * m, tolerance * u.norm() * a) << "cos of the lag at " << time;
    const double turn = std::sin(s.drive.phase_shift) > 0 ? -1 : 1;
    EXPECT_GT(turn * (u.x() * d.y() - u.y() * d.x()), 0) << "the velocity lags the drive";
  }
}

/// The return to it after a small disturbance: in the frame turning with the drive both components obey
/// z'' + k z' + w^2 z = 0 with k = m/U, so the map over a time T has the trace exp(l1 T) + exp(l2 T) and the
/// determinant exp(-k T), l the roots -k/2 +- sqrt(k^2/4 - w^2).
inline void return_to_steady_sliding(Scenario s, double tolerance, IntegrationOptions how = {}) {
  s.friction.pulse_width = 0;
  const auto orbit = steady_orbit(s, false);
  ASSERT_TRUE(orbit);
  s.start = Start::rest;
  s.initial_velocity = orbit->velocity;
  s.cycles = 1;  // a whole turn: the turning frame is back
  how.derivatives = {Parameter::velocity_x, Parameter::velocity_y};
  const Eigen::Matrix2d map = integrate(s, how).sensitive_end().velocity_jacobian;
  const double w = s.drive.angular_frequency,
               k = s.friction.nominal * s.drive.gravity / orbit->velocity.norm();
  const double time = 2 * kPi / w;
  const std::complex<double> root = std::sqrt(std::complex<double>(k * k / 4 - w * w));
  const std::complex<double> trace = std::exp((-k / 2 + root) * time) + std::exp((-k / 2 - root) * time);
  EXPECT_NEAR(map.trace(), trace.real(), tolerance);
  EXPECT_NEAR(map.determinant(), std::exp(-k * time), tolerance);
  EXPECT_NEAR(orbit->contraction, std::abs(std::exp((-k / 2 + root) * time)), 10 * tolerance);
}

/// phi -> phi + turn turns the steady drift by exactly -turn (clockwise drive), same length.
inline void rotation(Scenario s, double turn, double tolerance) {
  const auto before = steady_orbit(s);
  s.friction.phase += turn;
  const auto after = steady_orbit(s);
  ASSERT_TRUE(before && after);
  const double sense = std::sin(s.drive.phase_shift) > 0 ? -1 : 1;
  const Eigen::Vector2d expected = Eigen::Rotation2Dd(sense * turn) * before->drift;
  EXPECT_LT((after->drift - expected).norm(), tolerance * s.drive.amplitude);
}

/// (A, w) -> (A/q^2, q w) with the same mu g/(A w^2): x/A as a function of wt stays.
inline void scaling(const Scenario& s, double q, double tolerance, const IntegrationOptions& how = {}) {
  Scenario other = s;
  other.drive.amplitude /= q * q;
  other.drive.amplitude_y /= q * q;
  other.drive.angular_frequency *= q;
  other.initial_velocity /= q;
  const Trajectory a = integrate(s, how), b = integrate(other, how);
  const double size = a.end().position.norm() + s.drive.amplitude;
  for (const double part : looked_at(how, {0.2, 0.55, 0.9, 1.0})) {
    const Eigen::Vector2d x = a.at(part * a.end_time()).position, y = b.at(part * b.end_time()).position;
    EXPECT_LT((x - q * q * y).norm(), tolerance * size);
  }
}

/// mu = 0 from rest at phase 0, circular drive: the mean drift is A w along -y.
inline void frictionless_drift(Scenario s, double tolerance, const IntegrationOptions& how = {}) {
  s.friction.nominal = s.friction.reduced = 0;
  s.start = Start::rest;
  s.start_phase = 0;
  s.drive.phase_shift = kPi / 2;
  s.drive.amplitude_y = s.drive.amplitude;
  s.drive.tilt_x = s.drive.tilt_y = 0;
  s.initial_velocity.setZero();
  s.cycles = 7;
  const Trajectory t = integrate(s, how);
  const Eigen::Vector2d mean = t.end().position / t.end_time();
  const double speed = s.drive.amplitude * s.drive.angular_frequency;
  EXPECT_NEAR(mean.x(), 0, tolerance * speed);
  EXPECT_NEAR(mean.y(), -speed, tolerance * speed);
}

/// mu = 0, any ellipse, tilt, start: u and x are integrals of the drive in closed form.
inline void frictionless_motion(Scenario s, double tolerance, const IntegrationOptions& how = {}) {
  s.friction.nominal = s.friction.reduced = 0;
  s.start = Start::rest;
  s.cycles = 3.4;
  const Drive& d = s.drive;
  const double w = d.angular_frequency, s0 = s.start_phase;
  const auto along = [&](double amplitude, double phase, double tilt, double u0, double t, double& u,
                         double& x) {
    const double pull = d.gravity * std::sin(tilt), a = amplitude * w;
    u = u0 + a * (std::sin(phase + w * t) - std::sin(phase)) + pull * t;
    x = (u0 - a * std::sin(phase)) * t - amplitude * (std::cos(phase + w * t) - std::cos(phase)) +
        pull * t * t / 2;
  };
  const Trajectory trajectory = integrate(s, how);
  for (const double part : looked_at(how, {0.13, 0.5, 0.77, 1.0})) {
    const double t = part * trajectory.end_time();
    Eigen::Vector2d u, x;
    along(d.amplitude, s0, d.tilt_x, s.initial_velocity.x(), t, u.x(), x.x());
    along(d.amplitude_y, s0 + d.phase_shift, d.tilt_y, s.initial_velocity.y(), t, u.y(), x.y());
    const Sample sample = trajectory.at(t);
    EXPECT_LT((sample.velocity - u).norm(), tolerance * (u.norm() + d.amplitude * w));
    EXPECT_LT((sample.position - x).norm(), tolerance * (x.norm() + d.amplitude));
  }
}

/// d(u^2/2)/dt = d.u - mu g |u| between events, by central differences of the dense output of 8th order in
/// the spacing. Returns how many points were fit for comparison.
inline int energy(const Scenario& s, double tolerance, const IntegrationOptions& how = {}) {
  const Trajectory t = integrate(s, how);
  // A pulse, or a pause between two, shorter than the differences reach would hide in them.
  if (const double reach = 8 * 4e-3;
      s.friction.pulse_width < reach || s.friction.pulse_width > 2 * kPi - reach)
    return 0;
  const double w = s.drive.angular_frequency, h = 4e-3 / w;
  const double power = drive_amplitude(s) * drive_amplitude(s) / w;
  constexpr std::array weights = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  int compared = 0;
  for (int i = 1; i < 200; ++i) {
    const double time = t.end_time() * i / 200;
    if (time < 4 * h || time > t.end_time() - 4 * h) continue;
    const Sample now = t.at(time), low = t.at(time - 4 * h), high = t.at(time + 4 * h);
    // Away from switches and stops, and from u = 0 where u(t) bends sharply.
    if (low.mu != now.mu || high.mu != now.mu || now.state != State::slip || low.state != now.state ||
        high.state != now.state || now.velocity.norm() * w < 0.3 * drive_amplitude(s))
      continue;
    const auto kinetic = [&](double at) { return 0.5 * t.at(at).velocity.squaredNorm(); };
    double slope = 0;
    for (int k = 1; k <= 4; ++k)
      slope += weights[static_cast<size_t>(k - 1)] * (kinetic(time + k * h) - kinetic(time - k * h)) / h;
    const double expected = s.drive.acceleration(s.start_phase + w * time).dot(now.velocity) -
                            now.mu * s.drive.gravity * now.velocity.norm();
    EXPECT_NEAR(slope, expected, tolerance * power) << "t = " << time;
    ++compared;
  }
  return compared;
}

}  // namespace tribotrack::model::laws
