#include "vision/camera/pixels.h"

#include <gtest/gtest.h>

#include <random>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

std::vector<Picture> frames_with(double sigma, unsigned seed, double ground_texture) {
  std::mt19937 random(seed);
  test::TestScene scene;
  scene.width = 192;
  scene.height = 160;
  scene.ground_texture = test::random_waves(random, 15, 8, ground_texture);
  std::vector<Picture> frames;
  for (int k = 0; k < 6; ++k) {
    scene.discs = {{60.0 + 3 * k, 80, 20, 0, 170, {}}};
    frames.push_back(test::noisy(scene.render(), sigma, random));
  }
  return frames;
}

double noise_of(const std::vector<Picture>& consecutive) {
  NoiseEstimate estimate;
  for (std::size_t k = 1; k < consecutive.size(); ++k) estimate.add_pair(consecutive[k - 1], consecutive[k]);
  return estimate.variance(consecutive.front());
}

TEST(NoiseVariance, IsThatOfNoiseAndRoundingWhateverMoves) {
  for (const double sigma : {0.5, 8.0}) {
    SCOPED_TRACE(testing::Message() << "sigma " << sigma);
    EXPECT_NEAR(noise_of(frames_with(sigma, 11, 0)) / (sigma * sigma + 1.0 / 12), 1, 0.04);
    // Standing texture cancels in the differences.
    EXPECT_NEAR(noise_of(frames_with(sigma, 12, 15)) / (sigma * sigma + 1.0 / 12), 1, 0.04);
  }
}

TEST(NoiseVariance, SmallPictureHalfFullOfAMovingDisc) {
  std::mt19937 random(16);
  for (const double sigma : {1.0, 3.0}) {
    SCOPED_TRACE(testing::Message() << "sigma " << sigma);
    test::TestScene scene;
    scene.width = scene.height = 64;
    double sum = 0;
    constexpr int kRuns = 8;
    for (int run = 0; run < kRuns; ++run) {
      std::vector<Picture> frames;
      for (int k = 0; k < 6; ++k) {
        scene.discs = {{28.0 + 1.3 * k, 31, 15, 0, 170, {}}};
        frames.push_back(test::noisy(scene.render(), sigma, random));
      }
      sum += noise_of(frames) / kRuns;
    }
    EXPECT_NEAR(sum / (sigma * sigma + 1.0 / 12), 1, 0.02);
  }
}

TEST(NoiseVariance, ChangeOfLightCancels) {
  auto frames = frames_with(2, 13, 0);
  for (std::size_t k = 0; k < frames.size(); ++k)
    for (float& l : frames[k].levels()) l += static_cast<float>(5 * (k % 2));
  EXPECT_NEAR(noise_of(frames) / (4 + 1.0 / 12), 1, 0.05);
}

TEST(NoiseVariance, NeverBelowRounding) {
  EXPECT_EQ(noise_of({Picture(64, 64, 10), Picture(64, 64, 10)}), 1.0 / 12);
  EXPECT_EQ(noise_variance(Picture(64, 64, 10)), 1.0 / 12);
}

TEST(NoiseVariance, RepeatedFramesDoNotCount) {
  auto frames = frames_with(2, 14, 0);
  frames[1] = frames[0];
  frames[4] = frames[3];
  EXPECT_NEAR(noise_of(frames) / (4 + 1.0 / 12), 1, 0.06);
}

}  // namespace
}  // namespace tribotrack::vision
