#include "apps/watch/growing_campaign.h"

#include <gmock/gmock.h>

#include <numbers>

#include "apps/program/errors.h"

namespace tribotrack::apps {
namespace {

using fit::FitParameter;

TEST(GoalText, SharesWidthsAndAngles) {
  const auto goals = goals_from("mu1=1%,mu2=0.003,phase_lag_rad=0.5deg,amplitude_mm=0.01");
  ASSERT_EQ(goals.size(), 4U);
  EXPECT_EQ(goals[0].parameter, FitParameter::mu1);
  EXPECT_DOUBLE_EQ(goals[0].half_width, 0.01);
  EXPECT_TRUE(goals[0].relative);
  EXPECT_DOUBLE_EQ(goals[1].half_width, 0.003);
  EXPECT_FALSE(goals[1].relative);
  EXPECT_NEAR(goals[2].half_width, std::numbers::pi / 360, 1e-15);
  EXPECT_DOUBLE_EQ(goals[3].half_width, 1e-5) << "SI inside";
  EXPECT_TRUE(goals_from("").empty());
}

TEST(GoalText, WhatIsNoGoalIsRefusedWithAnExample) {
  for (const char* wrong : {"mu1", "mu1=", "mu1=-1%", "mu1=0", "mu9=1%", "mu1=1%,", "=1%", "mu1=nan%"}) try {
      goals_from(wrong);
      FAIL() << wrong;
    } catch (const UsageError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("mu1=1%")) << wrong;
    }
}

TEST(GoalText, AGoalOfWhatIsNotFittedIsRefused) {
  EXPECT_NO_THROW(require_fitted(goals_from("mu1=1%"), {FitParameter::mu1}));
  EXPECT_THROW(require_fitted(goals_from("mu2=1%"), {FitParameter::mu1}), UsageError);
}

}  // namespace
}  // namespace tribotrack::apps
