// Laws of model/trajectory.h about cycles: how memory fades, and what weak pulses do.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "model/laws.h"

namespace tribotrack::model::laws {

/// Two starts under one drive never separate.
inline void contraction(Scenario s, const Eigen::Vector2d& other_velocity,
                        const IntegrationOptions& how = {}) {
  Scenario other = s;
  other.initial_velocity = other_velocity;
  const Trajectory a = integrate(s, how), b = integrate(other, how);
  double last = (s.initial_velocity - other_velocity).norm();
  for (int i = how.dense ? 0 : 100; i <= 100; ++i) {
    const double time = i == 100 ? a.end_time() : a.end_time() * i / 100;
    const Eigen::Vector2d u = a.at(time).velocity, v = b.at(time).velocity;
    const double gap = (u - v).norm(), speed = u.norm() + drive_amplitude(s) / s.drive.angular_frequency;
    EXPECT_LE(gap, last * (1 + 1e-12) + 1e-14 * speed) << "sample " << i;
    last = gap;
  }
}

/// A common stick wipes the memory: from then on velocities repeat exactly, cycle by cycle, and positions
/// add.
inline void stick_repeats(const Scenario& s, const IntegrationOptions& how = {}) {
  const Trajectory t = integrate(s, how);
  ASSERT_GT(t.summary().stops, 1) << "the scenario must stick";
  const double period = 2 * kPi / s.drive.angular_frequency;
  const int cycles = static_cast<int>(s.cycles);
  const Eigen::Vector2d drift = t.at((cycles - 1) * period).position - t.at((cycles - 2) * period).position;
  for (int n = 2; n < cycles - 1; ++n) {
    for (const double part : {0.1, 0.37, 0.5, 0.93}) {
      const Sample a = t.at((n + part) * period), b = t.at((n + 1 + part) * period);
      const double speed = drive_amplitude(s) / s.drive.angular_frequency;
      EXPECT_LT((a.velocity - b.velocity).norm(), 1e-12 * speed);
      EXPECT_LT((b.position - a.position - drift).norm(), 1e-12 * (drift.norm() + s.drive.amplitude));
      EXPECT_EQ(a.state, b.state);
    }
  }
}

/// Bit by bit: runs that end at the same phase of later cycles end with the same velocity. (Fractions of a
/// cycle that are exact in binary: the phase itself must not be rounded.) Runs with other starts end with it
/// to rounding: steps may fall elsewhere, the motion is one.
inline void stick_wipes_every_bit(Scenario s, const IntegrationOptions& how = {}) {
  const Eigen::Vector2d start = s.initial_velocity;
  const double speed = drive_amplitude(s) / s.drive.angular_frequency;
  for (const double part : {0.0, 0.125, 0.375, 0.6875}) {
    s.cycles = 3 + part;
    s.initial_velocity = start;
    const Eigen::Vector2d expected = integrate(s, how).end().velocity;
    for (const double cycles : {4.0, 5.0, 9.0}) {
      s.cycles = cycles + part;
      s.initial_velocity = start;
      const Eigen::Vector2d end = integrate(s, how).end().velocity;
      EXPECT_EQ(end.x(), expected.x()) << s.cycles << " cycles";
      EXPECT_EQ(end.y(), expected.y()) << s.cycles << " cycles";
      for (const double u : {0.3, -0.7}) {
        s.initial_velocity = start + speed * Eigen::Vector2d(u, 0.4 * u);
        EXPECT_LT((integrate(s, how).end().velocity - expected).norm(), 1e-14 * speed)
            << s.cycles << " cycles, from " << u;
      }
    }
  }
}

/// Drift per unit of time = (m1 - m2) e^{i d0} s1 (2/k - i/w) for a weak pulse (clockwise drive, complex x +
/// iy in the frame of the drive at phase 0), asymptotically: the error falls linearly in m1 - m2, so it
/// halves with it.
inline void weak_pulse(Scenario s) {
  const double a = drive_amplitude(s), m = s.friction.nominal * s.drive.gravity,
               w = s.drive.angular_frequency;
  const double speed = std::sqrt((a - m) * (a + m)) / w, k = m / speed, lag = std::acos(m / a);
  const double phi = s.friction.phase + s.friction.lag, width = s.friction.pulse_width;
  const std::complex<double> i(0, 1);
  const std::complex<double> s1 =
      width / (2 * kPi) * std::sin(width / 2) / (width / 2) * std::exp(-i * (phi + width / 2));
  double last = 0;
  for (const double change : {4e-4, 2e-4, 1e-4, 5e-5}) {
    s.friction.reduced = s.friction.nominal * (1 - change);
    const auto orbit = steady_orbit(s);
    ASSERT_TRUE(orbit);
    const std::complex<double> drift(orbit->drift.x() * w / (2 * kPi), orbit->drift.y() * w / (2 * kPi));
    const std::complex<double> formula =
        m * (1 - s.friction.reduced / s.friction.nominal) * std::exp(i * lag) * s1 * (2 / k - i / w);
    const double error = std::abs(drift - formula) / std::abs(formula);
    EXPECT_LT(error, 30 * change);
    if (last > 0) {
      EXPECT_NEAR(error / last, 0.5, 0.02) << "mu1 - mu2 = " << change << " of mu1";
    }
    last = error;
  }
}

}  // namespace tribotrack::model::laws
