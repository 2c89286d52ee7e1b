#include "model/plan.h"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(LeastDrive, NothingBelowItOnAFineGrid) {
  RandomScenario random(4);
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
  RandomScenario random(12);
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

}  // namespace
}  // namespace tribotrack::model
