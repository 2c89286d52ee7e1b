#include "vision/discs/disc_detection.h"

#include <gtest/gtest.h>

namespace tribotrack::vision {
namespace {

DiscFit disc(double x, double radius, double score, double contrast = 100) {
  DiscFit fit;
  fit.circle = {x, 50, radius};
  fit.score = score;
  fit.contrast = contrast;
  return fit;
}

TEST(DiscsAlike, AreAsLargeAndSeenAsWellOrOfOneLook) {
  const DiscFit part = disc(0, 30, 200);
  EXPECT_TRUE(alike(disc(100, 26, 150, -40), part));  // as large, seen as well
  EXPECT_FALSE(alike(disc(100, 16, 190), part));      // a mark
  EXPECT_FALSE(alike(disc(100, 26, 60), part));       // hardly seen, and smaller
  EXPECT_TRUE(alike(disc(100, 29, 60, 90), part));    // half covered, of the same look
  EXPECT_FALSE(alike(disc(100, 29, 60, -90), part));  // of another look
}

TEST(DiscsAlike, GoFromLeftToRightWithoutWhatLiesInsideThePart) {
  const std::vector<DiscFit> found = {disc(100, 30, 200), disc(101, 27, 150), disc(20, 31, 190)};
  const auto all = discs_alike(found, found.front());
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].x, 20);
  EXPECT_EQ(all[1].x, 100);
}

TEST(DiscsAlike, TheNearestOfAboutTheGivenSize) {
  const std::vector<DiscFit> found = {disc(100, 30, 200), disc(40, 10, 150), disc(20, 29, 190)};
  EXPECT_EQ(nearest_like(found, {45, 50, 31}), &found[2]);
  EXPECT_EQ(nearest_like(found, {45, 50, 100}), nullptr);
}

}  // namespace
}  // namespace tribotrack::vision
