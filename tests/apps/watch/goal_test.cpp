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

TEST(GoalText, ProgressSaysWhatIsReachedAndWhatIsNot) {
  fit::FitResult result;
  result.parameters.resize(2);
  result.parameters[0].parameter = FitParameter::mu1;
  result.parameters[0].estimate = 0.1;
  result.parameters[0].ci95 = {0.0995, 0.1005};
  result.parameters[1].parameter = FitParameter::amplitude;
  result.parameters[1].estimate = 3e-4;
  result.parameters[1].ci95 = {2.8e-4, 3.2e-4};
  EXPECT_EQ(progress_of(goals_from("mu1=1%,amplitude_mm=0.01"), result),
            "mu1 to 1 %: reached, 0.5 %; amplitude_mm to 0.01: 0.02");
}

}  // namespace
}  // namespace tribotrack::apps
