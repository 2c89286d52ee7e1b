#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "fit/pooling.h"

namespace tribotrack::fit {
namespace {

constexpr double pi = std::numbers::pi;

PointMeasurement at(std::size_t point, double alpha, double alpha_sd, double v, double v_sd) {
  return {point, {{alpha, alpha_sd}, {v, v_sd}}};
}

TEST(PooledPoints, RepeatsOfOneSdGiveItOverTheRootOfTheirNumber) {
  for (const int n : {2, 3, 9}) {
    const std::vector<PointMeasurement> all(static_cast<std::size_t>(n), at(0, 1.2, 0.03, 5e-3, 2e-4));
    const PooledPoints pooled = pool_points(all);
    ASSERT_EQ(pooled.points.size(), 1u);
    EXPECT_NEAR(pooled.points[0].alpha.value, 1.2, 1e-15);
    EXPECT_NEAR(pooled.points[0].velocity.value, 5e-3, 1e-17);
    EXPECT_NEAR(pooled.points[0].alpha.sd, 0.03 / std::sqrt(n), 1e-15);
    EXPECT_NEAR(pooled.points[0].velocity.sd, 2e-4 / std::sqrt(n), 1e-18);
    EXPECT_EQ(pooled.scattered, 1);
    EXPECT_EQ(pooled.widened, 1);
  }
}

TEST(PooledPoints, DirectionsOnBothSidesOfZeroAreNear) {
  const PooledPoints pooled =
      pool_points(std::vector{at(0, 0.1, 0.05, 2e-3, 1e-4), at(0, 2 * pi - 0.1, 0.05, 2e-3, 1e-4)});
  EXPECT_NEAR(std::remainder(pooled.points[0].alpha.value, 2 * pi), 0, 1e-12);
  EXPECT_NEAR(pooled.points[0].velocity.value, 2e-3 * std::cos(0.1), 1e-15);
}

TEST(PooledPoints, ValuesAreWeightedByTheirSds) {
  // Same direction: v by 1/sd^2, (4 * 1 + 1 * 2) / 5.
  const PooledPoints pooled =
      pool_points(std::vector{at(0, 0.5, 0.1, 1e-3, 5e-4), at(0, 0.5, 0.1, 2e-3, 1e-3)});
  EXPECT_NEAR(pooled.points[0].velocity.value, 1.2e-3, 1e-16);
  EXPECT_NEAR(pooled.points[0].velocity.sd, 1e-3 / std::sqrt(5.0), 1e-16);
}

TEST(PooledPoints, WithoutSdsTheScatterOfAllRepeatsTells) {
  // Two points, twice each, in one direction: v off the means by 1e-4 and 3e-4, the more at the slower one,
  // so that s^2 = (2 * 1 + 2 * 9) e-8 / 2; Student's t of 2 degrees of freedom is 4.302653.
  const std::vector<PointMeasurement> all = {at(0, 1, 0.1, 4.9e-3, 0), at(0, 1, 0.1, 5.1e-3, 0),
                                             at(1, 2, 0.1, 2.7e-3, 0), at(1, 2, 0.1, 3.3e-3, 0),
                                             at(2, 3, 0.1, 1e-3, 0)};
  const PooledPoints pooled = pool_points(all);
  EXPECT_EQ(pooled.along.dof, 2u);
  EXPECT_FALSE(pooled.along.relative);
  EXPECT_NEAR(pooled.along.sd, std::sqrt(10.0) * 1e-4, 1e-15);
  EXPECT_EQ(pooled.across.sd, 0);
  EXPECT_NEAR(pooled.widened, 4.302653 / 1.959964, 1e-6);
  const double sd = pooled.widened * pooled.along.sd;
  EXPECT_NEAR(pooled.points[0].velocity.sd, sd / std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(pooled.points[1].velocity.sd, sd / std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(pooled.points[2].velocity.sd, sd, 1e-15);  // measured once, as well as the others
  EXPECT_NEAR(pooled.points[0].alpha.sd, 0.1 / std::sqrt(2.0), 1e-4);
}

TEST(PooledPoints, AScatterThatGrowsWithTheSpeedIsAShareOfIt) {
  // Off by 2 % along, and by 0.01 rad across, at speeds of 1 and 10: sqrt(2) times that is the sd of one.
  std::vector<PointMeasurement> all;
  for (const auto& [point, v] : {std::pair<std::size_t, double>(0, 1e-3), {1, 10e-3}})
    for (const double off : {-1.0, 1.0}) all.push_back(at(point, 1 + 0.01 * off, 0, v * (1 + 0.02 * off), 0));
  const PooledPoints pooled = pool_points(all);
  EXPECT_TRUE(pooled.along.relative);
  EXPECT_TRUE(pooled.across.relative);
  EXPECT_NEAR(pooled.along.sd, 0.02 * std::sqrt(2.0), 1e-5);
  EXPECT_NEAR(pooled.across.sd, 0.01 * std::sqrt(2.0), 1e-5);
  EXPECT_NEAR(pooled.points[1].velocity.sd / pooled.points[0].velocity.sd, 10, 1e-9);
  EXPECT_NEAR(pooled.points[1].alpha.sd / pooled.points[0].alpha.sd, 1, 1e-9);
  // The same errors in mm/s at both speeds are one speed, and the faster point's direction is the better
  // known.
  all.clear();
  for (const auto& [point, v] : {std::pair<std::size_t, double>(0, 1e-3), {1, 10e-3}})
    for (const double off : {-1.0, 1.0}) all.push_back(at(point, 1 + 1e-5 * off / v, 0, v + 2e-5 * off, 0));
  const PooledPoints even = pool_points(all);
  EXPECT_FALSE(even.along.relative);
  EXPECT_FALSE(even.across.relative);
  EXPECT_NEAR(even.points[1].velocity.sd / even.points[0].velocity.sd, 1, 1e-9);
  EXPECT_NEAR(even.points[1].alpha.sd / even.points[0].alpha.sd, 0.1, 1e-3);
}

TEST(PooledPoints, IntervalsFromTheScatterHoldInNinetyFiveOfAHundred) {
  std::mt19937_64 random(4711);
  std::normal_distribution<double> normal;
  int held_alpha = 0, held_v = 0;
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<PointMeasurement> all;  // three points, twice each: 3 degrees of freedom
    for (std::size_t point = 0; point < 3; ++point)
      for (int n = 0; n < 2; ++n)
        all.push_back(at(point, 6.2 + 0.05 * normal(random), 0, 5e-3 * (1 + 0.04 * normal(random)), 0));
    const PooledPoints pooled = pool_points(all);
    const AlphaV& one = pooled.points[0];
    held_alpha += std::abs(std::remainder(one.alpha.value - 6.2, 2 * pi)) < 1.959964 * one.alpha.sd;
    held_v += std::abs(one.velocity.value - 5e-3) < 1.959964 * one.velocity.sd;
  }
  // Four standard deviations of the count are 55. The mean vector is shorter than the mean velocity by a
  // thousandth, a thirtieth of the sd.
  EXPECT_NEAR(held_alpha, 0.95 * kTrials, 55);
  EXPECT_NEAR(held_v, 0.95 * kTrials, 55);
}

TEST(PooledPoints, SdsThatTheRepeatsRefuseAreWidenedEverywhere) {
  std::vector<PointMeasurement> all;
  for (std::size_t point = 0; point < 4; ++point)
    for (const double off : {-1.0, 1.0}) all.push_back(at(point, 1, 0.01, 5e-3 + off * 5e-4, 1e-4));
  all.push_back(at(4, 1, 0.01, 5e-3, 1e-4));
  const PooledPoints pooled = pool_points(all);
  // chi2 = 8 * 25 along, 0 across, of 4 + 4 degrees of freedom.
  EXPECT_NEAR(pooled.chi2, 200, 1e-9);
  EXPECT_EQ(pooled.chi2_dof, 8u);
  EXPECT_NEAR(pooled.scattered, 5, 1e-12);
  EXPECT_NEAR(pooled.points[4].velocity.sd, 5e-4, 1e-15);
  EXPECT_NEAR(pooled.points[0].velocity.sd, 5e-4 / std::sqrt(2.0), 1e-15);
}

TEST(PooledPoints, RefusesWhatIsNoMeasurement) {
  EXPECT_THROW(pool_points(std::vector{at(0, std::nan(""), 0.1, 1e-3, 1e-4)}), std::invalid_argument);
  EXPECT_THROW(pool_points(std::vector{at(0, 1, -0.1, 1e-3, 1e-4)}), std::invalid_argument);
  EXPECT_THROW(pool_points(std::vector{at(0, 1, 0.1, -1e-3, 1e-4)}), std::invalid_argument);
  EXPECT_THROW(pool_points(std::vector{at(1, 1, 0.1, 1e-3, 1e-4)}), std::invalid_argument);
}

}  // namespace
}  // namespace tribotrack::fit
