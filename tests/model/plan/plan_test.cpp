#include "model/plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "model/laws.h"
#include "model/random_scenario.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using laws::kPi;

PlanStage stage(const Scenario& s, const std::string& name) {
  for (const PlanStage& stage : plan(s))
    if (stage.name == name) return stage;
  throw std::runtime_error("no stage " + name);
}

Scenario pulsed(double mu1) {
  Scenario s;
  s.friction = {mu1, mu1 / 8, 0.5, kPi / 6, 0};
  return s;
}

TEST(LeastDrive, ClosedForms) {
  Drive d;
  d.amplitude = 2e-3;
  d.amplitude_y = 1e-3;
  d.angular_frequency = 10;
  EXPECT_NEAR(least_drive(d), 0.1, 1e-16);  // the ellipse's short half axis
  d.phase_shift = 0;
  EXPECT_NEAR(least_drive(d), 0, 1e-16);  // a line through 0
  d = Drive{};
  const double a = d.amplitude * std::pow(d.angular_frequency, 2);
  d.tilt_x = 0.03;
  d.tilt_y = 0.04;
  const double pull = d.gravity * std::hypot(std::sin(0.03), std::sin(0.04));
  EXPECT_NEAR(least_drive(d), a - pull, 1e-15);
  // A_y = A, epsilon: the short half axis is A w^2 sqrt(1 - |cos epsilon|).
  d = Drive{};
  d.phase_shift = 1.1;
  EXPECT_NEAR(least_drive(d), a * std::sqrt(1 - std::cos(1.1)), 1e-15);
}

TEST(LeastDrive, NothingBelowItOnAFineGrid) {
  const unsigned seed = 4;
  std::cout << "seed " << seed << '\n';
  RandomScenario random(seed);
  for (int i = 0; i < 50; ++i) {
    const Drive d = random.general().drive;
    double least = HUGE_VAL;
    for (int k = 0; k < 20000; ++k) least = std::min(least, d.acceleration(2 * kPi * k / 20000).norm());
    const double found = least_drive(d), size = d.acceleration(0).norm() + least;
    EXPECT_LE(found, least + 1e-15 * size);
    EXPECT_GT(found, least - 3e-4 * size);  // the grid's own distance from the minimum, where |d| has a cusp
  }
}

/// Where the plan says that nothing sticks, nothing does.
TEST(Plan, NoStickWhereItIsLeftOut) {
  const unsigned seed = 12;
  std::cout << "seed " << seed << '\n';
  RandomScenario random(seed);
  int without = 0;
  for (int i = 0; i < 200; ++i) {
    Scenario s = random.general();
    s.initial_velocity.setZero();
    if (stage(s, "stick and release").on) continue;
    ++without;
    EXPECT_EQ(integrate(s).summary().stops, 0) << i;
  }
  EXPECT_GT(without, 10);
}

TEST(Plan, SaysWhatTheSceneNeeds) {
  EXPECT_FALSE(stage(pulsed(0.1), "stick and release").on);
  EXPECT_TRUE(stage(pulsed(0.12), "stick and release").on);
  EXPECT_TRUE(stage(pulsed(0.1), "friction switches").on);
  Scenario s = pulsed(0.1);
  s.friction.reduced = s.friction.nominal;
  EXPECT_FALSE(stage(s, "friction switches").on);
  EXPECT_TRUE(stage(pulsed(0.1), "transient").on);
  s = pulsed(0.1);
  s.start = Start::steady;
  EXPECT_FALSE(stage(s, "transient").on);
}

TEST(Plan, WeakFrictionForgetsTooSlowlyToRepeat) {
  EXPECT_FALSE(stage(pulsed(0.1), "every cycle").on);
  EXPECT_TRUE(stage(pulsed(0.02), "every cycle").on);
  Scenario s = pulsed(0.1);
  s.friction.nominal = s.friction.reduced = 0;  // none at all
  EXPECT_TRUE(stage(s, "every cycle").on);
}

}  // namespace
}  // namespace tribotrack::model
