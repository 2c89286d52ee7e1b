#include "model/trajectory.h"

#include <gtest/gtest.h>

#include "model/laws.h"
#include "model/random_scenario.h"
#include "model/reference_error.h"

namespace tribotrack::model {
namespace {

using laws::kPi;
using laws::reference_run;
using reference::error_against_reference;

TEST(Trajectory, AgreesWithQuadruplePrecision) {
  RandomScenario random(20260);
  for (int i = 0; i < 100; ++i) {
    for (Scenario s : {random.circular(), random.general()}) {
      if (i % 4 == 3) s.duration = random.uniform(0.1, 2.3) * s.end_time();  // not whole cycles
      EXPECT_LT(reference::largest_error_against_reference(s), 1e-11) << "scenario " << i;
    }
  }
}

/// Starts on a periodic motion, elliptic and tilted ones too: it is periodic, and what follows is right.
TEST(Trajectory, StartsOnOrbitsAgreeWithQuadruplePrecision) {
  RandomScenario random(31);
  int compared = 0;
  while (compared < 40) {
    Scenario s = compared % 2 == 0 ? random.general() : random.circular();
    s.start = compared % 4 < 2 ? Start::steady : Start::circling;
    s.initial_velocity.setZero();
    if (!steady_orbit(s, s.start == Start::steady)) continue;  // tilted beyond the friction angle
    ++compared;
    SCOPED_TRACE(std::to_string(compared) + ", " + to_string(s.start));
    EXPECT_LT(reference::return_after_a_cycle(s), 1e-12);
    EXPECT_LT(error_against_reference(s), 1e-11);
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

/// Where the motion contracts noticeably, cycles repeat: more of them cost no more steps.
TEST(Trajectory, RepeatingCyclesAreFoundWhereverTheMotionContracts) {
  std::vector<Scenario> scenarios;
  for (const double mu : {0.06, 0.07, 0.08, 0.1, 0.11, 0.122})
    for (const double width : {kPi / 6, kPi / 3, kPi / 2, kPi}) {
      scenarios.push_back(reference_run());
      scenarios.back().friction = {mu, mu / 8, 0.5, width, 0};
    }
  RandomScenario random(3);
  for (int i = 0; i < 60; ++i) scenarios.push_back(random.circular());
  for (Scenario& s : scenarios) {
    const auto orbit = steady_orbit(s);
    if (!orbit || orbit->contraction > 0.5) continue;
    s.cycles = 150;
    const long steps = integrate(s).summary().steps;
    s.cycles = 300;
    EXPECT_EQ(integrate(s).summary().steps, steps)
        << "mu1 " << s.friction.nominal << " dtau " << s.friction.pulse_width << " contraction "
        << orbit->contraction;
  }
}

/// What was left out does not show at the end of a run by more than its bound and what the tolerance lets
/// pass anyway, however the motion came to repeat.
TEST(Trajectory, RepeatingCyclesEndWhereEveryCycleDoes) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomScenario random(seed);
  for (int i = 0; i < 60; ++i) {
    Scenario s = reference_run();
    const double mu = random.uniform(0.05, 0.35);
    s.friction = {mu, mu * random.uniform(0, 1), random.uniform(0, 2 * kPi), random.uniform(0, 2 * kPi), 0};
    if (i % 3 == 1) {
      s.drive.amplitude_y *= random.uniform(0.3, 1.3);
      s.drive.phase_shift = random.uniform(0, 6);
    }
    s.cycles = 80;
    const auto orbit = steady_orbit(s);
    if (!orbit || orbit->contraction > 0.9) continue;
    // What a cycle adds to the velocity's error stays for 1/(1 - contraction) cycles.
    const double path = 2 * kPi * s.cycles * s.drive.amplitude / (1 - orbit->contraction);
    for (const double tolerance : {1e-16, 1e-7})
      for (const bool dense : {false, true}) {
        IntegrationOptions options;
        options.tolerance = tolerance;
        options.dense = dense;
        const Trajectory reused = integrate(s, options);
        options.reuse_repeating_cycles = false;
        const Trajectory bare = integrate(s, options);
        EXPECT_LE((reused.end().position - bare.end().position).norm(), 2 * (tolerance + 2e-14) * path)
            << "scenario " << i << " tolerance " << tolerance << " dense " << dense;
      }
  }
}

TEST(Trajectory, MaxStepsIsAnError) {
  IntegrationOptions options;
  options.max_steps = 10;
  EXPECT_THROW(integrate(reference_run(), options), StepLimitExceeded);
}

}  // namespace
}  // namespace tribotrack::model
