#include "vision/formats/cine/p10.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace tribotrack::vision {
namespace {

TEST(P10, CurveHasItsPublishedPoints) {
  EXPECT_EQ(p10_linear_levels[0], 2);
  EXPECT_EQ(p10_linear_levels[64], 64);      // black
  EXPECT_EQ(p10_linear_levels[1014], 4064);  // white
  EXPECT_EQ(p10_linear_levels[1023], 4095);
  for (std::size_t code = 1; code < 1024; ++code)
    EXPECT_GE(p10_linear_levels[code], p10_linear_levels[code - 1]);
}

TEST(P10, CodeIsTheNearestOfAll) {
  for (int level = 0; level <= 4095; ++level) {
    int nearest = 5000;
    for (const int known : p10_linear_levels) nearest = std::min(nearest, std::abs(known - level));
    const std::uint16_t code = p10_code(level);
    ASSERT_EQ(std::abs(p10_linear_levels[code] - level), nearest) << level;
    if (code > 0) {
      ASSERT_LT(p10_linear_levels[code - 1u], p10_linear_levels[code]) << "not the lowest code";
    }
  }
  EXPECT_EQ(p10_code(-3), 0);
  EXPECT_EQ(p10_linear_levels[p10_code(1e6)], 4095);
}

}  // namespace
}  // namespace tribotrack::vision
