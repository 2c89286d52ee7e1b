#include "vision/coding/coded_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr int kSide = 64;
const Circle kAll{32, 32, 200};

/// A vertical edge, blurred with sd 0.75 px, in the middle of a column of blocks; or a horizontal one.
Picture edge(double contrast, bool horizontal = false) {
  Picture picture(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double off = (horizontal ? y : x) - 27.5;
      picture.at(x, y) = static_cast<float>(50 + 0.5 * contrast * std::erfc(-off / (0.75 * std::sqrt(2.0))));
    }
  return picture;
}

/// The slope of a step c has the mean coefficient c in a block of 8 x 8 px, and sqrt(2) c at the most.
TEST(DeadZone, OfAStraightEdgeLiesBetweenItsMeanAndItsLargestCoefficient) {
  const Point unnoticed = unnoticed_motion(edge(100), kAll, -1);
  EXPECT_GT(unnoticed.x, 1 / (std::sqrt(2.0) * 100));
  EXPECT_LT(unnoticed.x, 1.0 / 100);
}

TEST(DeadZone, TurnsWithThePicture) {
  const Point down = unnoticed_motion(edge(100), kAll, -1),
              across = unnoticed_motion(edge(100, true), kAll, -1);
  EXPECT_NEAR(down.x, across.y, 1e-9);
  EXPECT_EQ(down.y, 0) << "an edge tells nothing of a motion along itself";
}

}  // namespace
}  // namespace tribotrack::vision
