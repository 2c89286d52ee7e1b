#include "vision/tracking/plan_costs.h"

#include <gtest/gtest.h>

#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

TEST(PlanCosts, SavingsAreSharesOfTheRunWithTheStage) {
  std::vector<PlanStage> plan(3);
  plan[0].on = true;
  plan[0].cost = 300;
  plan[1].cost = 100;
  plan[2].on = true;
  predict_savings(plan, 100);
  EXPECT_DOUBLE_EQ(plan[0].predicted_saving, 300.0 / 400);  // of the run as it was
  EXPECT_DOUBLE_EQ(plan[1].predicted_saving, 100.0 / 500);  // of the run as it would have been
  EXPECT_EQ(plan[2].predicted_saving, 0);
}

TEST(PlanCosts, LearningIsSharedByAllFrames) {
  PlanCosts costs;
  costs.frames = 100;
  const double few = costs.layers(60, 100);
  costs.frames = 1e9;
  const double many = costs.layers(60, 100);
  EXPECT_GT(few, 2 * many);
  EXPECT_GT(many, 0);
}

}  // namespace
}  // namespace tribotrack::vision
