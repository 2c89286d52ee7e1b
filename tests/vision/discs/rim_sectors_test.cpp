#include "vision/discs/rim_sectors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

test::TestScene scene_of(double x, double y, double radius, double level) {
  test::TestScene scene;
  scene.discs = {{x, y, radius, 0, level, {}}};
  return scene;
}

TEST(RimSectors, AnEvenDiscIsWhereItIs) {
  for (const double level : {150.0, 12.0})
    for (const double radius : {9.0, 24.3}) {
      const Picture picture = scene_of(47.3, 48.6, radius, level).render();
      const auto rim = measure_rim_sectors(picture, {48, 48, radius + 0.2}, 0.76);
      ASSERT_TRUE(rim) << radius;
      EXPECT_NEAR(rim->circle.x, 47.3, 2e-3);
      EXPECT_NEAR(rim->circle.y, 48.6, 2e-3);
      // A blurred curved edge lies inwards by s^2 / (2 R).
      EXPECT_NEAR(rim->circle.radius, radius - 0.76 * 0.76 / (2 * radius), 0.01);
      EXPECT_EQ(rim->coverage, 1);
      EXPECT_GT(rim->correlation, 0.999);
      EXPECT_TRUE(same_rim(*rim, shape_of(*rim, 0.76, {rim->circle.x, rim->circle.y})));
    }
}

TEST(RimSectors, LevelsThatVaryAlongTheRimDoNotMoveTheCircle) {
  test::TestScene scene = scene_of(47.3, 48.6, 24.3, 150);
  // One wave across the disc: bright on one side, dark on the other.
  scene.discs[0].texture.waves = {{40, M_PI / 60, 0.02, 0.7}};
  const auto rim = measure_rim_sectors(scene.render(), {47.5, 48.4, 24.3}, 0.76);
  ASSERT_TRUE(rim);
  EXPECT_NEAR(rim->circle.x, 47.3, 0.02);
  EXPECT_NEAR(rim->circle.y, 48.6, 0.02);
}

TEST(RimSectors, OtherRoundThingsAreNotThePart) {
  const Picture part = scene_of(47.3, 48.6, 20, 150).render();
  const auto seen = measure_rim_sectors(part, {47, 48.5, 20}, 0.76);
  ASSERT_TRUE(seen);
  const RimShape known = shape_of(*seen, 0.76, {seen->circle.x, seen->circle.y});
  const auto is_the_part = [&](const Picture& picture) {
    const auto rim = measure_rim_sectors(picture, {47, 48.5, 20}, 0.76);
    return rim && same_rim(*rim, known);
  };
  EXPECT_TRUE(is_the_part(part));
  EXPECT_TRUE(is_the_part(scene_of(47.9, 48.1, 20, 130).render()));     // less light
  EXPECT_FALSE(is_the_part(scene_of(47.3, 48.6, 21.5, 150).render()));  // larger
  EXPECT_TRUE(is_the_part(scene_of(47.3, 48.6, 20, 20).render()));  // metal that has turned out of the light
  EXPECT_FALSE(is_the_part(test::TestScene{}.render()));            // nothing there
  test::TestScene covered = scene_of(47.3, 48.6, 20, 150);
  covered.discs.push_back({62, 48, 22, 0, 100, {}});  // a hand over half of its rim
  EXPECT_FALSE(is_the_part(covered.render()));
}

}  // namespace
}  // namespace tribotrack::vision
