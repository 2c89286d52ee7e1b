#include "vision/layers/evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tribotrack::vision {
namespace {

/// A parabola flown through, with white noise.
std::vector<TimedPoint> thrown(std::int64_t frames, double noise, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto error = [&](auto& generator) { return noise * normal(generator); };
  std::vector<TimedPoint> out;
  for (std::int64_t k = 0; k < frames; ++k) {
    const auto t = static_cast<double>(k);
    out.push_back(
        {100 + k,
         {40 + 1.7 * t - 0.002 * t * t + error(random), 9 - 0.4 * t + 0.001 * t * t + error(random)}});
  }
  return out;
}

// The squares of third differences, 20 times the noise's, are correlated over three frames: their median is
// known to 3 % over 4000 of them.
TEST(FrameNoise, IsThatOfWhiteNoiseOnAParabola) {
  for (const double noise : {1e-3, 0.04}) EXPECT_NEAR(frame_noise(thrown(4000, noise)), noise, 0.05 * noise);
}

TEST(FrameNoise, ParabolaItselfIsQuiet) {
  EXPECT_LT(frame_noise(thrown(300, 0)), 1e-12);
}

TEST(FrameNoise, CollisionDoesNotCount) {
  std::vector<TimedPoint> track = thrown(400, 0.01);
  const double before = frame_noise(track);
  for (std::size_t k = 200; k < track.size(); ++k) track[k].place.x += 5 - 3.0 * static_cast<double>(k - 200);
  EXPECT_NEAR(frame_noise(track), before, 0.03 * before);
}

// A cubic over frames that are not neighbours would be noise if they were taken for such.
TEST(FrameNoise, OnlyConsecutiveFramesCount) {
  std::vector<TimedPoint> track = thrown(40, 0);
  for (TimedPoint& p : track) p.place.x += (p.frame / 4) % 2 == 0 ? 0 : 30;
  EXPECT_GT(frame_noise(track), 1);
  // Runs of four: one difference each, within which nothing jumps.
  for (TimedPoint& p : track) p.frame += p.frame / 4;
  EXPECT_LT(frame_noise(track), 1e-12);
}

TEST(FrameNoise, IsUnknownOfFewerThanFourFrames) {
  EXPECT_TRUE(std::isinf(frame_noise({})));
  EXPECT_TRUE(std::isinf(frame_noise(thrown(3, 0.01))));
  EXPECT_TRUE(std::isfinite(frame_noise(thrown(4, 0.01))));
  std::vector<TimedPoint> gaps = thrown(40, 0.01);
  for (TimedPoint& p : gaps) p.frame *= 2;
  EXPECT_TRUE(std::isinf(frame_noise(gaps)));
}

}  // namespace
}  // namespace tribotrack::vision
