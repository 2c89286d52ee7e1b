#include "vision/synthesis/edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "vision/disc_by_definition.h"

namespace tribotrack::vision {
namespace {

TEST(BlurredCircle, IsASharpDiscConvolvedWithAGaussian) {
  for (const double blur : {0.1, 0.8, 3.0})
    for (const double radius : {2.5, 8.0, 30.0, 150.0}) {
      const BlurredCircle circle{radius, blur};
      for (double x = -4.4; x < 4.4; x += 0.13) {
        const double rho = radius + x * blur;
        if (rho < 0) continue;
        EXPECT_NEAR(circle.coverage(0.6 * rho, -0.8 * rho), test::share_on_disc(rho, radius, blur), 5e-6)
            << radius << " " << blur << " " << x;
      }
    }
}

TEST(BlurredCircle, KnownValues) {
  EXPECT_NEAR((BlurredCircle{2, 1}.coverage(0, 0)), 1 - std::exp(-2.0), 1e-5);
  EXPECT_EQ((BlurredCircle{12, 0.8}.coverage(0, 0)), 1);
  EXPECT_EQ((BlurredCircle{12, 0.8}.coverage(-20, 0)), 0);
  EXPECT_EQ((BlurredCircle{}.coverage(0, 0)), 0);
  // Half height lies s^2/(2R) inside the rim.
  EXPECT_NEAR((BlurredCircle{12, 0.8}.coverage(12 - 0.32 / 12, 0)), 0.5, 1e-4);
}

TEST(BlurredCircle, BlurKeepsTheArea) {
  for (const double blur : {0.3, 0.8, 4.0}) {
    const BlurredCircle circle{12, blur};
    double area = 0;
    const int steps = 100000;
    for (int k = 0; k < steps; ++k) {
      const double rho = 40 * (k + 0.5) / steps;
      area += 2 * std::numbers::pi * rho * circle.coverage(rho, 0) * 40 / steps;
    }
    EXPECT_NEAR(area / (std::numbers::pi * 144), 1, 2e-5) << blur;
  }
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
