// The edge in bands of time on a disc whose Cramer-Rao bound is known in closed form.
#include "vision/edge/edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

constexpr double kRadius = 12, kBlur = 0.76, kNoise = 2;
constexpr std::int64_t kFrames = 600;  ///< more than are learnt from

Point truth(std::int64_t k) {
  const auto t = static_cast<double>(k);
  return {30.3 + 2 * std::cos(0.13 * t) + 0.002 * t, 29.6 - 2 * std::sin(0.13 * t)};
}

test::RenderedSource even_disc() {
  return {60, 60, kFrames, [](std::int64_t k) {
            test::TestScene scene;
            scene.width = scene.height = 60;
            scene.discs = {{truth(k).x, truth(k).y, kRadius, 0, 140, {}}};
            std::mt19937 noise(static_cast<unsigned>(900 + k));
            return test::noisy(scene.render(), kNoise, noise);
          }};
}

/// As a first pass might leave them.
SeenFrames guesses() {
  std::mt19937 random(4);
  std::normal_distribution<double> off(0, 0.2);
  SeenFrames out;
  for (std::int64_t k = 0; k < kFrames; ++k)
    out.push_back({k, {truth(k).x + off(random), truth(k).y + off(random)}, {}});
  return out;
}

/// Of a step c blurred by a Gaussian s along a rim of radius R: the sum of its squared gradient, times cos^2,
/// over the noise is c^2 / (2 sqrt(pi) s) pi R / sigma^2.
double bound(double contrast) {
  const double information =
      std::pow(contrast / kNoise, 2) / (2 * std::sqrt(std::numbers::pi) * kBlur) * std::numbers::pi * kRadius;
  return 1 / std::sqrt(information);
}

TEST(EdgeTrack, IsAtTheBoundWithATrueSdForAnyNumberOfThreads) {
  test::RenderedSource source = even_disc();
  const EdgeOptions options{.radius = kRadius - 0.4, .noise_variance = kNoise * kNoise};
  const EdgeTrack track = track_edge(source, guesses(), options);
  ASSERT_EQ(track.fixes.size(), static_cast<std::size_t>(kFrames));
  EXPECT_LE(track.learnt_from, 512U);
  EdgeOptions shared = options;
  shared.threads = 3;
  const EdgeTrack again = track_edge(source, guesses(), shared);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double squares = 0, variances = 0;
  for (std::int64_t k = 0; k < kFrames; ++k) {
    const auto& fix = track.fixes[static_cast<std::size_t>(k)];
    ASSERT_TRUE(fix) << k;
    EXPECT_EQ(fix->centre.x, again.fixes[static_cast<std::size_t>(k)]->centre.x) << k;
    const Eigen::Vector2d error(fix->centre.x - truth(k).x, fix->centre.y - truth(k).y);
    mean += error / kFrames;
    squares += error.squaredNorm() / (2 * kFrames);
    variances += fix->covariance.trace() / (2 * kFrames);
  }
  const double variance = squares - mean.squaredNorm() / 2;
  // A scene's ground lies at 60.
  EXPECT_LT(std::sqrt(variance), 1.15 * bound(140 - 60));
  EXPECT_GT(std::sqrt(variance / variances), 0.8);
  EXPECT_LT(std::sqrt(variance / variances), 1.2);
}

TEST(EdgeTrack, LeavesFramesOutWhereTheRimLeavesThePicture) {
  test::RenderedSource source = even_disc();
  SeenFrames frames = guesses();
  frames.resize(40);
  frames[7].centre = {10, 30};
  const EdgeTrack track = track_edge(source, frames, {.radius = kRadius, .noise_variance = kNoise * kNoise});
  ASSERT_EQ(track.fixes.size(), 40U);
  EXPECT_FALSE(track.fixes[7]);
  EXPECT_TRUE(track.fixes[8]);
  frames.resize(5);
  EXPECT_TRUE(track_edge(source, frames, {.radius = kRadius}).fixes.empty());
}

}  // namespace
}  // namespace tribotrack::vision
