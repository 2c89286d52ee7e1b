#include "vision/discs/mean_radius.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vision/layered_scenes.h"

namespace tribotrack::vision {
namespace {

/// The radius as tracking a plain platform finds it, with the disc at its true places.
std::optional<MeanRadius> watch(const test::SlidingScene& s, double radius) {
  test::SceneSource source(s);
  RimWatch rim({0, 0, radius}, 5);
  for (int k = 0; k < s.frames; ++k) rim.see(source, k, s.truth(k));
  return rim.radius();
}

struct SlidingDisc {
  static constexpr int kFrames = 60;
  Scene scene;
  double speed;

  SlidingDisc(double radius, double first_speed, std::uint64_t seed) : speed(first_speed) {
    scene.width = 210;
    scene.height = 60;
    scene.seed = seed;
    scene.platform.level = 20;
    scene.platform.texture_rms = 0;
    scene.disc.radius_px = radius;
    scene.disc.scratches = 0;
    scene.disc.highlight = 0;
    scene.disc.edge_blur_px = 0.5;
  }
  /// Slower and slower: at rest in the last frame. t in frames.
  ScenePose pose(double t) const {
    return {{30.3 + speed * (t - t * t / (2 * kFrames)), 30.2 + 0.1 * speed * t}, 0, {0, 0}};
  }
  std::vector<Picture> smeared() const {
    const SceneRenderer renderer(scene);
    std::vector<Picture> pictures;
    for (int k = 0; k < kFrames; ++k) {
      pictures.push_back(renderer.render_exact(k, 1, [&](double t) { return pose(t); }));
      std::mt19937 random(static_cast<unsigned>(scene.seed) * 1000 + static_cast<unsigned>(k));
      std::normal_distribution<float> noise(0, 1.2F);
      for (float& level : pictures.back().levels()) level = std::round(level + noise(random));
    }
    return pictures;
  }
};

// A disc that stays over one place of a textured platform: all frames see the same ground beyond the rim. The
// sd is that of few independent stretches of the rim, its square is right on average.
TEST(RimWatch, KnowsWhatTheGroundBeyondTheRimDoes) {
  double sum = 0, squares = 0, variance = 0;
  constexpr int kCount = 50;
  for (int k = 0; k < kCount; ++k) {
    test::SlidingScene s;
    s.frames = 30;
    s.path_px = 0;
    s.scene.width = 150;
    s.scene.seed = static_cast<std::uint64_t>(100 + k);
    s.scene.disc.radius_px = 11.3 + 0.013 * k;
    const auto mean = watch(s, s.scene.disc.radius_px);
    ASSERT_TRUE(mean);
    const double error = mean->radius - s.scene.disc.radius_px;
    sum += error / kCount;
    squares += error * error / kCount;
    variance += mean->sd * mean->sd / kCount;
  }
  const double ratio = std::sqrt(squares / variance);
  std::printf("mean error %+.4f px, rms %.4f, over sd %.2f\n", sum, std::sqrt(squares), ratio);
  EXPECT_GT(ratio, 0.5);
  EXPECT_LT(ratio, 1.45);
}

/// A disc that comes to rest under a shutter that is always open.
TEST(RimWatch, HoldsUnderMotionBlur) {
  constexpr double kSpeed = 1.5;  // px a frame, at first
  double squares = 0;
  int count = 0;
  for (const double radius : {8.7, 15.3}) {
    const SlidingDisc disc(radius, kSpeed, static_cast<std::uint64_t>(10 + count));
    MemorySource source(disc.smeared(), 250);
    RimWatch rim({0, 0, radius}, 2);
    for (int k = 0; k < SlidingDisc::kFrames; ++k) rim.see(source, k, disc.pose(k).disc);
    const auto mean = rim.radius();
    ASSERT_TRUE(mean);
    std::printf("radius %g: error %+.4f, sd %.4f px\n", radius, mean->radius - radius, mean->sd);
    squares += std::pow((mean->radius - radius) / mean->sd, 2);
    EXPECT_LT(std::abs(mean->radius - radius) / radius, 0.002);
    ++count;
  }
  EXPECT_LT(std::sqrt(squares / count), 2.2);
}

TEST(MeanRadius, WhatBelongsToTheDiscDoesNotAverageOut) {
  DiscFit fit;
  fit.circle.radius = 30;
  fit.white_radius_sd = 1e-4;
  for (int k = 0; k < 36; ++k) fit.sector_pull.push_back(k % 2 == 0 ? 0.001 : -0.001);
  const double once = mean_radius({&fit, 1}).sd;
  const std::vector<DiscFit> often(50, fit);
  EXPECT_NEAR(mean_radius(often).sd, once, 1e-12);
  EXPECT_NEAR(once, 0.001 * 36 / std::sqrt(33.0), 1e-9);  // 36 sectors; their mean and the centre taken off
}

TEST(MeanRadius, AnUnevenDiscLeavesWhatNoRecordingAveragesOut) {
  DiscFit fit;
  fit.circle.radius = 30;
  fit.white_radius_sd = 1e-3;
  fit.unevenness = 0.1;
  const MeanRadius mean = mean_radius(std::vector<DiscFit>(10'000, fit));
  EXPECT_NEAR(mean.common_sd, 0.002, 1e-12);
  EXPECT_NEAR(mean.sd, std::hypot(0.002, 1e-5), 1e-9);
}

}  // namespace
}  // namespace tribotrack::vision
