#include "vision/registration/pattern.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vision/scene.h"

namespace tribotrack::vision {
namespace {

double limit_of(int scratches, double highlight, double noise, std::uint64_t seed) {
  Scene scene;
  scene.width = scene.height = 100;
  scene.disc.scratches = scratches;
  scene.disc.scratch_contrast = 12;
  scene.disc.highlight = highlight;
  scene.platform.texture_rms = 10;
  scene.read_noise = noise;
  scene.seed = seed;
  const ScenePose pose{{50.3, 49.8}, 0, {}};
  const Picture frame = SceneRenderer(scene).render(0, 0, 0, [&](double) { return pose; });
  const Pattern disc = disc_pattern(frame, {pose.disc.x, pose.disc.y, 30}, {0});
  Picture window(disc.window.width, disc.window.height);
  for (int y = 0; y < window.height(); ++y)
    for (int x = 0; x < window.width(); ++x) window.at(x, y) = frame.at(disc.window.x + x, disc.window.y + y);
  return rotation_limit(window, disc, noise * noise + 1.0 / 12);
}

TEST(RotationVisibility, ScratchesShowItInTheirNoiseReflectionsDoNot) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    for (const double noise : {1.2, 2.0, 4.0}) {
      SCOPED_TRACE(testing::Message() << "noise " << noise);
      EXPECT_GT(limit_of(0, 0, noise, seed), 1);
      EXPECT_GT(limit_of(0, 25, noise, seed), 1);
      EXPECT_LT(limit_of(12, 0, noise, seed), 0.01);
      EXPECT_LT(limit_of(12, 25, noise, seed), 0.01);
    }
  }
}

TEST(RotationVisibility, LimitIsInProportionToTheNoise) {
  // The bound is sigma over the root of the texture's information.
  EXPECT_NEAR(limit_of(12, 0, 3, 1) / limit_of(12, 0, 1, 1), 3, 0.4);
}

}  // namespace
}  // namespace tribotrack::vision
