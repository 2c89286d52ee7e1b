#include "vision/layers/model/rim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tribotrack::vision {
namespace {

TEST(RimProfile, StartsAsTheBlurredEdgeAndEndsAtNothingAndAll) {
  const RimProfile rim(30, 0.8);
  EXPECT_EQ(rim.at(0), 0);
  EXPECT_EQ(rim.at(rim.inner()), 0);
  EXPECT_EQ(rim.at(rim.outer()), 1);
  EXPECT_EQ(rim.at(100), 1);
  EXPECT_NEAR(rim.at(30), 0.5, 0.01);
  EXPECT_GE(rim.outer() - 30, 4 * 0.8);
  EXPECT_LT(RimProfile(4, 1.5).outer(), 8);  // never more than half of a small disc
}

TEST(RimProfile, LearnsTheTrueProfileFromRegressions) {
  // The truth is another edge: wider and half a pixel further out.
  RimProfile rim(30, 0.8);
  const auto truth = [](double rho) {
    return 1 - 0.5 * std::erfc((rho - 30.4) / (std::numbers::sqrt2 * 0.9));
  };
  for (double rho = 25; rho < 36; rho += 0.01) rim.add(rho, 1000 * truth(rho), 1000);
  rim.solve(1);
  for (double rho = 28.5; rho < 32.5; rho += 0.1) EXPECT_NEAR(rim.at(rho), truth(rho), 0.015) << rho;
}

TEST(RimProfile, StaysWhereNothingIsLearnt) {
  RimProfile rim(30, 0.8);
  const RimProfile before = rim;
  rim.solve(2);
  for (double rho = 26; rho < 34; rho += 0.25) EXPECT_NEAR(rim.at(rho), before.at(rho), 1e-12);
}

}  // namespace
}  // namespace tribotrack::vision
