#include "vision/millimetres.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace tribotrack::vision {
namespace {

TEST(Scale, ItsSdHoldsThatOfTheRadiusAndOfTheTrueDiameter) {
  EXPECT_DOUBLE_EQ(scale_from_diameter(6, 30, 0.03).sd, 0.1 * 0.03 / 30);
  EXPECT_DOUBLE_EQ(scale_from_diameter(6, 30, 0, 0.006).sd, 0.1 * 0.001);
  EXPECT_DOUBLE_EQ(scale_from_diameter(6, 30, 0.03, 0.008).sd, 0.1 * std::hypot(0.001, 0.008 / 6));
}

TEST(PooledScale, IsTheWeightedMean) {
  const std::vector<Scale> scales = {{0.10, 0.001, "a"}, {0.103, 0.002, "a"}};
  const PooledScale pooled = pooled_scale(scales);
  EXPECT_DOUBLE_EQ(pooled.scale.mm_per_px, (4 * 0.10 + 0.103) / 5);
  EXPECT_DOUBLE_EQ(pooled.scale.sd, 0.002 / std::sqrt(5.0));
  EXPECT_NEAR(pooled.chi2, 0.003 * 0.003 / (0.001 * 0.001 + 0.002 * 0.002), 1e-12);
  EXPECT_TRUE(pooled.one_scale);
}

TEST(PooledScale, WhatAllShareIsNotAveragedAway) {
  // A diameter known to 1 % and radii to 0.1 %: 100 recordings still leave 1 %.
  const std::vector<Scale> scales(100, {0.1, 0.1 * std::hypot(0.01, 0.001), "a"});
  EXPECT_NEAR(pooled_scale(scales, 0.01).scale.sd, 0.1 * std::hypot(0.01, 0.0001), 1e-12);
}

TEST(PooledScale, ACameraThatMovedIsSeen) {
  EXPECT_FALSE(pooled_scale(std::vector<Scale>{{0.10, 1e-4, "a"}, {0.101, 1e-4, "a"}}).one_scale);
  EXPECT_FALSE(pooled_scale(std::vector<Scale>{{0.10, 0, "a"}, {0.101, 0, "a"}}).one_scale);
  EXPECT_TRUE(pooled_scale(std::vector<Scale>{{0.10, 0, "a"}, {0.10, 0, "a"}}).one_scale);
  EXPECT_THROW(pooled_scale({}), std::invalid_argument);
}

// Ten radii of 30 px that scatter by 0.006 px where each believes 0.002.
TEST(PooledScale, RimsThatScatterMoreThanTheyKnowStillShareOneScale) {
  std::vector<Scale> scales;
  double squares = 0;
  for (int k = 0; k < 10; ++k) {
    const double off = (k - 4.5) / 2.8723 * 2e-4;  // sd 2e-4
    squares += off * off;
    scales.push_back({0.1 * (1 + off), 0.1 * 0.7e-4, "a"});
  }
  const PooledScale pooled = pooled_scale(scales);
  EXPECT_TRUE(pooled.one_scale);
  // Equal weights: the moments' scatter and own variance together are the sample variance.
  const double sample = 0.1 * std::sqrt(squares / 9);
  EXPECT_NEAR(std::hypot(pooled.scatter, 0.1 * 0.7e-4), sample, 1e-9);
  EXPECT_NEAR(pooled.scale.sd, sample / std::sqrt(10.0), 1e-9);
  EXPECT_NEAR(pooled.scale.mm_per_px, 0.1, 1e-12);
}

TEST(PooledScale, ScatterIsNeededBeyondTheExactQuantile) {
  // Two degrees of freedom: chi-squared exceeds x with probability exp(-x / 2), so one in 1000 is 13.8155.
  for (const double chi2 : {13.80, 13.83}) {
    const double off = 1e-4 * std::sqrt(chi2 / 2);
    const std::vector<Scale> scales = {{0.1 - off, 1e-4, "a"}, {0.1, 1e-4, "a"}, {0.1 + off, 1e-4, "a"}};
    EXPECT_NEAR(pooled_scale(scales).chi2, chi2, 1e-9);
    EXPECT_EQ(pooled_scale(scales).scatter > 0, chi2 > 13.8155) << chi2;
  }
}

}  // namespace
}  // namespace tribotrack::vision
