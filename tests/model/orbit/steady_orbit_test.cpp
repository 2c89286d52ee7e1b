#include "model/steady_orbit.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <string>

#include "model/laws.h"
#include "model/random_scenario.h"

namespace tribotrack::model {
namespace {

using laws::kPi;
using laws::reference_run;

TEST(SteadyOrbit, ContractionVanishesWithStick) {
  Scenario s = reference_run();
  s.friction.nominal = 0.3;
  const auto orbit = steady_orbit(s);
  ASSERT_TRUE(orbit);
  EXPECT_EQ(orbit->contraction, 0);
}

/// Steps enough for any one cycle of the search are too few for all of them together.
TEST(SteadyOrbit, TheWholeSearchIsCountedInSteps) {
  Scenario s = reference_run();
  s.friction.nominal = 0.05;                      // slides throughout
  s.drive.amplitude_y = 0.1 * s.drive.amplitude;  // no circle: one cycle after the other
  const auto orbit = steady_orbit(s);
  ASSERT_TRUE(orbit);
  ASSERT_GE(orbit->newton_iterations, 4);
  s.cycles = 1;
  Scenario one_cycle = s;
  one_cycle.initial_velocity = orbit->velocity;
  const long steps = integrate(one_cycle).summary().steps;
  s.start = Start::steady;
  IntegrationOptions options;
  options.max_steps = 2 * steps;
  try {
    integrate(s, options);
    ADD_FAILURE() << "found in " << options.max_steps << " steps";
  } catch (const StepLimitExceeded& error) {
    EXPECT_NE(std::string(error.what()).find(std::to_string(options.max_steps)), std::string::npos)
        << error.what();
  }
  options.max_steps = 2 * (orbit->newton_iterations + 2) * steps;
  EXPECT_EQ(integrate(s, options).end().position, integrate(s).end().position);
}

/// One cycle from that velocity, by the integrator.
Sample after_a_cycle(Scenario s, const Eigen::Vector2d& velocity) {
  s.initial_velocity = velocity;
  s.cycles = 1;
  return integrate(s).end();
}

/// Spectral radius of the one-cycle map by central differences.
double contraction_by_differences(const Scenario& s, const Eigen::Vector2d& velocity, double step) {
  Eigen::Matrix2d map;
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d by = step * Eigen::Vector2d::Unit(k);
    map.col(k) =
        (after_a_cycle(s, velocity + by).velocity - after_a_cycle(s, velocity - by).velocity) / (2 * step);
  }
  return map.eigenvalues().cwiseAbs().maxCoeff();
}

/// In every instruction set a cycle from the orbit comes back to it, goes as far and contracts as much: for
/// any circular drive, any ellipse, edges where the cycle begins, and friction reduced to next to nothing for
/// nearly the whole cycle.
TEST(SteadyOrbit, ComesBackAfterACycle) {
  RandomScenario random(41);
  std::vector<Scenario> scenarios;
  for (int i = 0; i < 40; ++i) {
    scenarios.push_back(random.circular());
    if (i % 2 == 0) scenarios.back().drive.phase_shift *= -1;
    scenarios.push_back(random.general());
    scenarios.back().initial_velocity.setZero();
  }
  for (const double phase : {0.0, -1.2, 1e-13, -1e-13, 2 * kPi - 1.2}) {
    scenarios.push_back(reference_run());
    scenarios.back().friction = {0.1, 0.0125, phase, 1.2, 0};
  }
  for (const double mu : {0.02, 0.1, 0.122})
    for (const double ratio : {50.0, 1e3, 1e6})
      for (const double width : {5.0, 5.9, 6.2, 6.28}) {
        scenarios.push_back(reference_run());
        scenarios.back().friction = {mu, mu / ratio, 0, width, 0};
      }
  for (const Scenario& s : scenarios) {
    const auto orbit = steady_orbit(s);
    SCOPED_TRACE("mu1 " + std::to_string(s.friction.nominal) + " mu2 " + std::to_string(s.friction.reduced) +
                 " dtau " + std::to_string(s.friction.pulse_width) + " A_y/A " +
                 std::to_string(s.drive.amplitude_y / s.drive.amplitude));
    if (!orbit && s.drive.tilt_x * s.drive.tilt_y != 0) continue;  // tilted beyond the friction angle
    ASSERT_TRUE(orbit);
    const double speed = laws::drive_amplitude(s) / s.drive.angular_frequency;
    const Sample end = after_a_cycle(s, orbit->velocity);
    EXPECT_LT((end.velocity - orbit->velocity).norm(), 1e-12 * speed);
    EXPECT_LT((end.position - orbit->drift).norm(), 2e-12 * s.drive.amplitude);
    EXPECT_LT(orbit->newton_iterations, 40);
    EXPECT_LT(orbit->contraction, 1);
    if (orbit->contraction > 0) {
      EXPECT_NEAR(orbit->contraction, contraction_by_differences(s, orbit->velocity, 1e-5 * speed), 1e-3);
    }
  }
}

TEST(SteadyOrbit, NoneWithoutFriction) {
  Scenario s = reference_run();
  s.friction.nominal = s.friction.reduced = 0;
  EXPECT_FALSE(steady_orbit(s));
  s = reference_run();
  s.friction.nominal = 0;
  EXPECT_FALSE(steady_orbit(s, false));
}

TEST(SteadyOrbit, NoneBeyondTheFrictionAngle) {
  Scenario s = reference_run();
  s.friction.pulse_width = 0;
  s.drive.tilt_x = std::asin(0.1001);
  EXPECT_FALSE(steady_orbit(s));
  s.drive.tilt_x = std::asin(0.05);
  EXPECT_TRUE(steady_orbit(s));
}

TEST(SteadyOrbit, RestIsTheOrbitOfAPartThatIsHeld) {
  Scenario s = reference_run();
  s.friction = {0.2, 0.15, 0, 1, 0};
  const auto orbit = steady_orbit(s);
  ASSERT_TRUE(orbit);
  EXPECT_EQ(orbit->velocity.norm(), 0);
  EXPECT_EQ(orbit->drift.norm(), 0);
}

}  // namespace
}  // namespace tribotrack::model
