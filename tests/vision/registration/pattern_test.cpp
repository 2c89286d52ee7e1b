#include "vision/registration/pattern.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

test::TestScene one_disc() {
  test::TestScene scene;
  scene.discs = {{48.3, 47.6, 15, 0, 170, {}}};
  return scene;
}

TEST(DiscPattern, MaskIsTheCirclePlusItsMargin) {
  const Pattern p = disc_pattern(one_disc().render(), {48.3, 47.6, 15});
  for (int y = 0; y < p.window.height; ++y)
    for (int x = 0; x < p.window.width; ++x) {
      const double rho = std::hypot(x + p.window.x - 48.3, y + p.window.y - 47.6);
      EXPECT_EQ(p.weights.at(x, y) > 0, rho <= 18);
    }
}

TEST(DiscPattern, NeighbourInTheRimIsLeftOut) {
  test::TestScene scene = one_disc();
  scene.discs.push_back({48.3 + 31, 47.6, 15, 0, 170, {}});  // touches, 1 px apart
  const Pattern p = disc_pattern(scene.render(), {48.3, 47.6, 15});
  EXPECT_EQ(p.weights.at(48 + 17 - p.window.x, 48 - p.window.y), 0);
  EXPECT_EQ(p.weights.at(48 - 17 - p.window.x, 48 - p.window.y), 1);
  EXPECT_EQ(p.weights.at(48 + 10 - p.window.x, 48 - p.window.y), 1);
}

TEST(Pattern, InsideAndOverlaps) {
  const Pattern p = disc_pattern(one_disc().render(), {48.3, 47.6, 15});
  const Rect bounds{0, 0, 96, 96};
  EXPECT_TRUE(p.inside(bounds, {15.5, 48}, 1));
  EXPECT_FALSE(p.inside(bounds, {15.4, 48}, 1));
  EXPECT_TRUE(p.inside(bounds, {79.5, 48}, 1));
  EXPECT_FALSE(p.inside(bounds, {79.6, 48}, 1));
  EXPECT_TRUE(p.overlaps(bounds, {-14, 48}));
  EXPECT_FALSE(p.overlaps(bounds, {-16, 48}));
}

TEST(RadialProfile, IsTheDiscsOwn) {
  const auto profile = radial_profile(one_disc().render(), {48.3, 47.6}, 20);
  EXPECT_NEAR(profile[3], 170, 0.5);
  EXPECT_NEAR(profile[15], 115, 6);
  EXPECT_NEAR(profile[19], 60, 0.5);
}

}  // namespace
}  // namespace tribotrack::vision
