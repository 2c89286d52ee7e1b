#include "model/trajectory.h"

#include <gtest/gtest.h>

#include <chrono>
#include <iostream>

#include "model/laws.h"
#include "model/quad_reference.h"
#include "model/random_scenario.h"

namespace tribotrack::model {
namespace {

using laws::kPi;

Scenario reference_run() {
  Scenario s;
  s.friction = {0.1, 0.0125, 0.5, kPi / 2, 0};
  return s;
}

Scenario tiny_run() {
  Scenario s = reference_run();
  s.drive.amplitude = s.drive.amplitude_y = 3e-9;
  s.drive.angular_frequency = 2e4;
  const double a = laws::drive_amplitude(s);
  s.friction.nominal = 0.4 * a / s.drive.gravity;
  s.friction.reduced = 0.1 * a / s.drive.gravity;
  return s;
}

/// Error of the product against quadruple precision, relative to how far the part gets.
double error_against_reference(const Scenario& s) {
  const Trajectory t = integrate(s);
  const Sample end = t.end();
  const auto exact = reference::integrate(reference::QuadScenario(s));
  double size = 0.01 * s.drive.amplitude;
  for (int i = 0; i <= 50; ++i) size = std::max(size, t.at(t.end_time() * i / 50).position.norm());
  const double dx = std::hypot(static_cast<double>(exact.x - end.position.x()),
                               static_cast<double>(exact.y - end.position.y()));
  const double du = std::hypot(static_cast<double>(exact.ux - end.velocity.x()),
                               static_cast<double>(exact.uy - end.velocity.y()));
  return std::max(dx, du / s.drive.angular_frequency) / size;
}

TEST(Trajectory, ReferenceRun) {
  const Sample end = integrate(reference_run()).end();
  // In quadruple precision (tests/model/quad_reference.h).
  EXPECT_NEAR(end.position.x(), 5.4702108186974206e-3, 2e-17);
  EXPECT_NEAR(end.position.y(), -1.0983961946988498e-2, 2e-17);
  EXPECT_DOUBLE_EQ(end.time, 20 * 2 * kPi / 62.8);
}

TEST(Trajectory, LawsHoldForOrdinaryTinyAndRandomScenarios) {
  const unsigned seed = std::random_device{}();
  std::cout << "seed " << seed << '\n';
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomScenario random(seed);
  std::vector<Scenario> scenarios = {reference_run(), tiny_run()};
  for (int i = 0; i < 20; ++i) scenarios.push_back(random.circular());
  int energy_points = 0;
  for (const Scenario& s : scenarios) {
    const double ratio = s.friction.nominal * s.drive.gravity / laws::drive_amplitude(s);
    SCOPED_TRACE("m/a = " + std::to_string(ratio));
    if (ratio < 0.98) {
      laws::steady_sliding(s, 1e-11);
      laws::return_to_steady_sliding(s, 1e-11);
    }
    laws::rotation(s, 1.234, 1e-11);
    laws::scaling(s, 1e-11);
    laws::frictionless_drift(s, 1e-13);
    energy_points += laws::energy(s, 1e-9);
    const double speed = laws::drive_amplitude(s) / s.drive.angular_frequency;
    laws::contraction(s, speed * Eigen::Vector2d(0.3, -0.8));
  }
  EXPECT_GT(energy_points, 200);
}

TEST(Trajectory, StickWipesTheMemory) {
  for (const double mu : {0.12, 0.2, 0.4, 3.0}) {
    Scenario s = reference_run();
    s.friction.nominal = mu;
    s.friction.pulse_width = kPi / 6;
    s.cycles = 9;
    laws::stick_repeats(s);
  }
}

/// drift per unit of time = (m1 - m2) e^{i d0} s1 (2/k - i/w) for a weak pulse (clockwise drive, complex x +
/// iy in the frame of the drive at phase 0): the error must fall linearly in m1 - m2.
TEST(Trajectory, WeakPulseFormulaIsTheLimit) {
  Scenario s = reference_run();
  const double a = laws::drive_amplitude(s), m = s.friction.nominal * s.drive.gravity,
               w = s.drive.angular_frequency;
  const double speed = std::sqrt(a * a - m * m) / w, k = m / speed, lag = std::acos(m / a);
  const double phi = s.friction.phase, width = s.friction.pulse_width;
  const std::complex<double> i(0, 1);
  const std::complex<double> s1 =
      width / (2 * kPi) * std::sin(width / 2) / (width / 2) * std::exp(-i * (phi + width / 2));
  double last = 0;
  for (const double change : {1e-2, 1e-3, 1e-4, 1e-5}) {
    s.friction.reduced = s.friction.nominal * (1 - change);
    const auto orbit = steady_orbit(s);
    ASSERT_TRUE(orbit);
    const std::complex<double> drift(orbit->drift.x() * w / (2 * kPi), orbit->drift.y() * w / (2 * kPi));
    const std::complex<double> formula = m * change * std::exp(i * lag) * s1 * (2 / k - i / w);
    const double error = std::abs(drift - formula) / std::abs(formula);
    EXPECT_LT(error, 3 * change);
    if (last > 0) {
      EXPECT_NEAR(error / last, 0.1, 0.02);
    }
    last = error;
  }
}

TEST(Trajectory, FreeSlideIsAStraightLineWithAnExactStop) {
  Scenario s;
  s.drive.amplitude = s.drive.amplitude_y = 0;
  s.friction = {0.2, 0.2, 0, 0, 0};
  s.initial_velocity = {0.3, -0.4};
  s.duration = 1;
  const Trajectory t = integrate(s);
  const double deceleration = 0.2 * 9.81, stop = 0.5 / deceleration;
  for (const double time : {0.1 * stop, 0.5 * stop, 0.99 * stop}) {
    const double path = 0.5 * time - deceleration * time * time / 2;
    EXPECT_NEAR(t.at(time).position.x(), 0.6 * path, 1e-16);
    EXPECT_NEAR(t.at(time).position.y(), -0.8 * path, 1e-16);
  }
  const Sample end = t.end();
  EXPECT_EQ(end.velocity.norm(), 0);
  EXPECT_EQ(end.state, State::stick);
  EXPECT_NEAR(end.position.norm(), 0.25 / (2 * deceleration), 1e-16);
  EXPECT_EQ(t.summary().stops, 1);
  EXPECT_NEAR(t.summary().stick_time, 1 - stop, 1e-14);
}

TEST(Trajectory, AgreesWithQuadruplePrecision) {
  const unsigned seed = 20260;
  std::cout << "seed " << seed << '\n';
  RandomScenario random(seed);
  double worst = 0;
  for (int i = 0; i < 60; ++i) {
    for (const Scenario& s : {random.circular(), random.general()}) {
      const double error = error_against_reference(s);
      EXPECT_LT(error, 1e-11) << "scenario " << i;
      worst = std::max(worst, error);
    }
  }
  std::cout << "worst relative error " << worst << '\n';
}

TEST(Trajectory, MotionAlongALineRunsThroughZero) {
  for (const double epsilon : {0.0, kPi, 1e-8}) {
    for (const double mu : {0.02, 0.1, 0.2}) {
      Scenario s = reference_run();
      s.drive.phase_shift = epsilon;
      s.friction.nominal = mu;
      s.start_phase = 0.3;
      s.cycles = 2;
      EXPECT_LT(error_against_reference(s), 1e-11) << "epsilon " << epsilon << " mu " << mu;
    }
  }
}

TEST(Trajectory, NearMissesOfZero) {
  for (const double miss : {1e-3, 1e-8, 1e-14, 0.0, -1e-14, -1e-8}) {
    Scenario s = reference_run();
    s.friction.nominal = 0.05;
    s.friction.pulse_width = 0;
    s.drive.amplitude_y = 0;
    s.initial_velocity = Eigen::Vector2d(-0.01, 0.01 * miss);
    s.cycles = 1.2;
    EXPECT_LT(error_against_reference(s), 1e-11) << "miss " << miss;
  }
}

/// The marginal case a = mu g: results change by about as much as the parameter does.
TEST(Trajectory, ContinuousAcrossTheStickThreshold) {
  Scenario s = reference_run();
  const double threshold = laws::drive_amplitude(s) / s.drive.gravity;
  const auto end = [&](double factor) {
    s.friction.nominal = threshold * factor;
    return integrate(s).end().position;
  };
  const Eigen::Vector2d middle = end(1);
  for (const double change : {1e-3, 1e-6, 1e-9, 1e-12}) {
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_LT((end(1 + sign * change) - middle).norm(), 0.1 * change + 1e-16) << sign * change;
    }
  }
}

TEST(Trajectory, SumsOfHugePhasesLoseNothing) {
  Scenario s = reference_run();
  const Eigen::Vector2d plain = integrate(s).end().position;
  s.friction.phase = 0.5 - 2 * kPi;
  EXPECT_LT((integrate(s).end().position - plain).norm(), 1e-17);
  s.friction.phase = 1e6;
  s.friction.lag = -999999.5;
  EXPECT_LT((integrate(s).end().position - plain).norm(), 1e-15);
}

TEST(Trajectory, PulsesOfZeroAndFullWidth) {
  Scenario s = reference_run(), constant = s;
  s.friction.pulse_width = 0;
  constant.friction.reduced = constant.friction.nominal;
  EXPECT_LT((integrate(s).end().position - integrate(constant).end().position).norm(), 1e-17);
  s.friction.pulse_width = 2 * kPi;
  constant = s;
  constant.friction.nominal = constant.friction.reduced;
  EXPECT_LT((integrate(s).end().position - integrate(constant).end().position).norm(), 1e-16);
  for (const double nearly : {1e-9, 2 * kPi - 1e-9}) {
    s.friction.pulse_width = nearly > 1 ? 2 * kPi : 0;
    const Eigen::Vector2d limit = integrate(s).end().position;
    s.friction.pulse_width = nearly;
    EXPECT_LT((integrate(s).end().position - limit).norm(), 1e-9);
  }
}

TEST(Trajectory, StartsOnTheCircleUntilTheFirstPulseOpens) {
  Scenario s = reference_run();
  s.start = Start::circling;
  s.start_phase = 1.0;  // inside a pulse, which does not count
  const Trajectory t = integrate(s);
  const double opening = (0.5 + 2 * kPi - 1.0) / s.drive.angular_frequency;
  const double radius_speed = t.at(0).velocity.norm();
  EXPECT_NEAR(t.at(0.99 * opening).velocity.norm(), radius_speed, 1e-15);
  EXPECT_EQ(t.at(0.99 * opening).mu, 0.1);
  EXPECT_EQ(t.at(1.01 * opening).mu, 0.0125);
}

TEST(Trajectory, StartsOnTheSteadyOrbit) {
  for (const double mu : {0.05, 0.1, 0.12, 0.3}) {
    Scenario s = reference_run();
    s.friction.nominal = mu;
    s.start = Start::steady;
    s.start_phase = 0.7;
    s.cycles = 5;
    const auto orbit = steady_orbit(s);
    ASSERT_TRUE(orbit);
    EXPECT_LT((integrate(s).end().position - 5 * orbit->drift).norm(), 1e-16);
  }
}

TEST(Trajectory, AMillionCyclesAddUp) {
  Scenario s = reference_run();
  s.cycles = 1e6;
  const Eigen::Vector2d far = integrate(s).end().position;
  s.cycles = 100;
  const Eigen::Vector2d near = integrate(s).end().position, drift = steady_orbit(s)->drift;
  EXPECT_LT((far - near - (1e6 - 100) * drift).norm(), 1e-12 * far.norm());
}

/// Extremes: finite, and no slower than fifty times the ordinary run in steps.
TEST(Trajectory, ExtremesStayFiniteAndCheap) {
  const double threshold = laws::drive_amplitude(reference_run()) / 9.81;
  std::vector<std::pair<std::string, Scenario>> cases;
  const auto add = [&](const std::string& name, auto change) {
    Scenario s = reference_run();
    change(s);
    cases.emplace_back(name, s);
  };
  add("mu2 = 0", [](Scenario& s) { s.friction.reduced = 0; });
  add("mu1 = 0", [](Scenario& s) { s.friction.nominal = 0; });
  add("mu1/mu2 = 1e6", [](Scenario& s) { s.friction.reduced = 1e-7; });
  for (const double e : {1e-3, 1e-6, 1e-9, 1e-12, 0.0, -1e-12, -1e-9, -1e-6, -1e-3}) {
    add("m/a = 1 + " + std::to_string(e), [&](Scenario& s) { s.friction.nominal = threshold * (1 + e); });
    add("m/a = 1 + e, constant", [&](Scenario& s) {
      s.friction.nominal = threshold * (1 + e);
      s.friction.pulse_width = 0;
    });
    add("m/a = 2 + e", [&](Scenario& s) { s.friction.nominal = threshold * (2 + e); });
  }
  add("m/a = 1e3", [&](Scenario& s) { s.friction.nominal = 1e3 * threshold; });
  add("m/a = 1e-4", [&](Scenario& s) { s.friction = {1e-4 * threshold, 1e-5 * threshold, 0.5, 1, 0}; });
  for (const double epsilon : {0.0, kPi, 1e-8, -kPi / 2})
    for (const double mu : {0.05, 0.1, 0.12, 0.2})
      add("epsilon " + std::to_string(epsilon) + " mu " + std::to_string(mu), [&](Scenario& s) {
        s.drive.phase_shift = epsilon;
        s.friction.nominal = mu;
      });
  for (const double w : {1e-3, 1e5}) add("w", [&](Scenario& s) { s.drive.angular_frequency = w; });
  for (const double amplitude : {0.0, 1e-9, 1.0})
    add("A", [&](Scenario& s) { s.drive.amplitude = s.drive.amplitude_y = amplitude; });
  for (const double speed : {1e-300, 1e-17, 1e-8, 1e3})
    add("v0", [&](Scenario& s) { s.initial_velocity = Eigen::Vector2d(speed, speed / 3); });
  for (const double e : {-1e-9, 0.0, 1e-9})
    add("tilt", [&](Scenario& s) { s.drive.tilt_x = std::asin(0.1 * (1 + e)); });
  for (const double tilt : {0.006, 0.0075, 0.0078, 0.00784})
    add("smooth take-off", [&](Scenario& s) {
      s.friction = {0.12, 0.12, 0, 0, 0};
      s.drive.tilt_x = tilt;
    });
  IntegrationOptions options;
  options.derivatives = {Parameter::mu1, Parameter::mu2, Parameter::lag};
  options.max_steps = 20'000;
  for (const auto& [name, s] : cases) {
    SCOPED_TRACE(name);
    const Trajectory plain = integrate(s);
    EXPECT_TRUE(plain.end().position.allFinite());
    EXPECT_LT(plain.summary().steps, 50 * 400);
    const Trajectory differentiated = integrate(s, options);
    EXPECT_TRUE(differentiated.sensitive_end().position_jacobian.allFinite());
    EXPECT_LE((plain.end().position - differentiated.end().position).norm(),
              1e-12 * (s.drive.amplitude + plain.end().position.norm()));
  }
}

TEST(Trajectory, MaxStepsIsAnError) {
  IntegrationOptions options;
  options.max_steps = 10;
  EXPECT_THROW(integrate(reference_run(), options), std::runtime_error);
}

TEST(Trajectory, SmoothTakeOffAgreesWithQuadruplePrecision) {
  Scenario s = reference_run();
  s.friction = {0.12, 0.12, 0, 0, 0};
  s.drive.tilt_x = 0.03;
  s.cycles = 1.5;
  EXPECT_GT(integrate(s).summary().stops, 0);
  EXPECT_LT(error_against_reference(s), 1e-11);
}

}  // namespace
}  // namespace tribotrack::model
