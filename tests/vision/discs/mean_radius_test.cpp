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
};

TEST(RimWatchCampaign, DISABLED_ManyFramesTellTheRadiusWhateverTheLampDoes) {
  double squares = 0;
  int count = 0;
  for (const double highlight : {0.0, 25.0, -30.0})
    for (const double radius : {29.7, 30.2, 45.4}) {
      test::SlidingScene s;
      s.frames = 60;
      s.scene.width = 300;
      s.scene.height = 130;
      s.scene.read_noise = 2;
      s.scene.seed = static_cast<std::uint64_t>(100 + count);
      s.scene.platform.texture_rms = 0;
      s.scene.disc.radius_px = radius;
      s.scene.disc.highlight = highlight;
      const auto mean = watch(s, radius);
      ASSERT_TRUE(mean);
      EXPECT_NEAR(mean->radius, radius, 0.005) << highlight;
      EXPECT_LT(mean->sd, highlight == 0 ? 0.0025 : 0.005);
      std::printf("highlight %g, radius %g: error %+.5f, sd %.5f px\n", highlight, radius,
                  mean->radius - radius, mean->sd);
      squares += std::pow((mean->radius - radius) / mean->sd, 2);
      ++count;
    }
  std::printf("radius from 12 frames: rms of standardised errors %.3f\n", std::sqrt(squares / count));
  EXPECT_LT(std::sqrt(squares / count), 1.7);  // chi-squared of 9, once in 1000
  EXPECT_GT(std::sqrt(squares / count), 0.35);
}

// A disc that stays over one place of a textured platform: all frames see the same ground beyond the rim. The
// sd is that of few independent stretches of the rim, its square is right on average; what a highlight may do
// is held by a bound, so that there it is too large rather than too small.
void expect_sd_over_ground(double texture, double highlight, double radius) {
  double sum = 0, squares = 0, variance = 0;
  constexpr int kCount = 50;
  for (int k = 0; k < kCount; ++k) {
    test::SlidingScene s;
    s.frames = 30;
    s.path_px = 0;
    s.scene.width = 150;
    s.scene.seed = static_cast<std::uint64_t>(100 + k);
    s.scene.platform.texture_rms = texture;
    s.scene.disc.radius_px = radius + 0.013 * k;
    s.scene.disc.highlight = highlight;
    const auto mean = watch(s, s.scene.disc.radius_px);
    ASSERT_TRUE(mean);
    const double error = mean->radius - s.scene.disc.radius_px;
    sum += error / kCount;
    squares += error * error / kCount;
    variance += mean->sd * mean->sd / kCount;
  }
  const double ratio = std::sqrt(squares / variance);
  std::printf("texture %g, highlight %g, radius %g: mean error %+.4f px, rms %.4f, over sd %.2f\n", texture,
              highlight, radius, sum, std::sqrt(squares), ratio);
  EXPECT_GT(ratio, 0.5);
  EXPECT_LT(ratio, 1.45);
}

TEST(RimWatch, KnowsWhatTheGroundBeyondTheRimDoes) {
  expect_sd_over_ground(6, 0, 11.3);
}

TEST(RimWatchCampaign, DISABLED_KnowsWhatTheGroundBeyondTheRimDoesToDiscsOfAnySize) {
  for (const double texture : {0.0, 6.0})
    for (const double highlight : {0.0, 15.0})
      for (const double radius : {9.5, 11.3, 14.8, 29.2}) expect_sd_over_ground(texture, highlight, radius);
}

/// A disc that comes to rest under a shutter that is always open, its light stored as such or to a power.
class SmearedSource : public MemorySource {
 public:
  SmearedSource(const SlidingDisc& disc, double power, bool colour)
      : MemorySource(rendered(disc, power), 250) {
    info_.colour = colour;
  }

 private:
  static std::vector<Picture> rendered(const SlidingDisc& disc, double power) {
    const SceneRenderer renderer(disc.scene);
    std::vector<Picture> pictures;
    for (int k = 0; k < SlidingDisc::kFrames; ++k) {
      Picture exact = renderer.render_exact(k, 1, [&](double t) { return disc.pose(t); });
      std::mt19937 random(static_cast<unsigned>(disc.scene.seed) * 1000 + static_cast<unsigned>(k));
      std::normal_distribution<double> noise(0, 1.2);
      for (float& v : exact.levels())
        v = static_cast<float>(
            std::round(255 * std::pow(static_cast<double>(v) / 255, power) + noise(random)));
      pictures.push_back(std::move(exact));
    }
    return pictures;
  }
};

void expect_radius_under_blur(bool colour, double speed) {
  double squares = 0, worst = 0;
  int count = 0;
  for (const double radius : {8.7, 15.3}) {
    SlidingDisc disc(radius, speed, static_cast<std::uint64_t>(10 + count));
    SmearedSource source(disc, colour ? 1 / 2.2 : 1, colour);
    RimWatch rim({0, 0, radius}, 2);
    for (int k = 0; k < SlidingDisc::kFrames; ++k) rim.see(source, k, disc.pose(k).disc);
    const auto mean = rim.radius();
    ASSERT_TRUE(mean);
    std::printf("%s, %g px a frame at first, radius %g: error %+.4f, sd %.4f px\n",
                colour ? "colour" : "linear", speed, radius, mean->radius - radius, mean->sd);
    squares += std::pow((mean->radius - radius) / mean->sd, 2);
    worst = std::max(worst, std::abs(mean->radius - radius) / radius);
    ++count;
  }
  EXPECT_LT(std::sqrt(squares / count), 2.2);
  EXPECT_LT(worst, colour ? 0.015 : 0.002);
}

TEST(RimWatch, HoldsUnderMotionBlur) {
  expect_radius_under_blur(false, 1.5);
}

TEST(RimWatchCampaign, DISABLED_HoldsUnderMotionBlurHoweverTheLightIsStored) {
  for (const bool colour : {false, true})
    for (const double speed : {0.0, 1.5, 4.0}) expect_radius_under_blur(colour, speed);
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
