#include "vision/kernels/median.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace tribotrack::vision {
namespace {

TEST(Median, OfOddAndEvenCountsAndOfNone) {
  EXPECT_EQ(median(std::vector{7}), 7);
  EXPECT_EQ(median(std::vector{3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median(std::vector{4.0F, 1.0F, 3.0F, 2.0F}), 3.0F) << "the upper of the two in the middle";
  EXPECT_EQ(median(std::vector<double>()), 0);
}

TEST(Median, SpreadOfNormalNumbersIsTheirSd) {
  constexpr unsigned seed = 3;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(5, 2);
  std::vector<double> values(100001);
  for (double& v : values) v = normal(random);
  const double middle = median(values);
  for (double& v : values) v = std::abs(v - middle);
  EXPECT_NEAR(kNormalMad * median(values), 2,
              5 * 2 * 1.17 / std::sqrt(1e5));  // sd of a MAD: 1.17 sigma / sqrt n
}

}  // namespace
}  // namespace tribotrack::vision
