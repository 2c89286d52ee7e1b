#include "vision/scene_edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tribotrack::vision {
namespace {

TEST(BlurredCircle, IsHalfOnItsRim) {
  const BlurredCircle circle{12, 0.8};
  EXPECT_DOUBLE_EQ(circle.coverage(12, 0), 0.5);
  EXPECT_EQ(circle.coverage(0, 0), 1);
  EXPECT_EQ(circle.coverage(-20, 0), 0);
  EXPECT_NEAR(circle.coverage(0, 12.8), 0.15865525393145707, 1e-14);
  EXPECT_NEAR(circle.coverage(6, 0) + circle.coverage(18, 0), 1, 0);
}

TEST(RowBand, HoldsEveryTouchedPixelAndOnlyFilledOnes) {
  const unsigned seed = 20;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-15, 45);
  for (int trial = 0; trial < 200; ++trial) {
    const BlurredCircle circle{std::abs(place(random)) / 2 + 0.5, 0.5};
    const std::vector<Point> centres{{place(random), place(random)}, {place(random), place(random)}};
    const int width = 31;
    for (int row = 0; row < 23; ++row) {
      const RowBand band = row_band(circle, centres, row, width);
      for (int x = 0; x < width; ++x) {
        bool touched = false, filled = true;
        for (const Point& c : centres) {
          for (double dy = -0.5; dy <= 0.5; dy += 0.125) {
            for (double dx = -0.5; dx <= 0.5; dx += 0.125) {
              const double coverage = circle.coverage(x + dx - c.x, row + dy - c.y);
              touched = touched || coverage > 0;
              filled = filled && coverage == 1;
            }
          }
        }
        if (touched) {
          EXPECT_TRUE(x >= band.touched.first && x <= band.touched.last);
        }
        if (x >= band.filled.first && x <= band.filled.last) {
          EXPECT_TRUE(filled);
        }
      }
      if (!band.touched.empty()) {
        EXPECT_TRUE(band.touched.first >= 0 && band.touched.last < width);
      }
      if (!band.filled.empty()) {
        EXPECT_TRUE(band.filled.first >= 0 && band.filled.last < width);
      }
    }
  }
}

TEST(RowBand, FarAwayCirclesTouchNothing) {
  const Point far{1e12, -1e12};
  const RowBand band = row_band({30, 0.8}, {&far, 1}, 5, 100);
  EXPECT_TRUE(band.touched.empty());
  EXPECT_TRUE(band.filled.empty());
}

}  // namespace
}  // namespace tribotrack::vision
