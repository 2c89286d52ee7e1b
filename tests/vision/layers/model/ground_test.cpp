#include "vision/layers/model/ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "vision/layers/part_by_hand.h"

namespace tribotrack::vision {
namespace {

using test::PartByHand;
using test::state_of;

constexpr int kWidth = 100, kHeight = 80;

/// A frame of waves that have moved by p: exact at every place.
Picture frame_of(const test::Waves& texture, const Point& p, double light = 1) {
  Picture out(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      out.at(x, y) = static_cast<float>(light * (70 + texture(x - p.x, y - p.y)));
  return out;
}

test::Waves some_waves() {
  std::mt19937 random(5);
  return test::random_waves(random, 12, 8, 6);
}

Point circling(int k) {
  return {2.7 * std::cos(0.5 * k), 2.7 * std::sin(0.5 * k)};
}

const Circle kNothing{-1000, -1000, 1};

/// G at whole places of the region, where it is not interpolated.
double level_at(const GroundPicture& ground, int x, int y) {
  return ground.mean() + ground.spline().value(x - ground.region().x, y - ground.region().y);
}

TEST(GroundPicture, IsThePlatformInItsOwnFrameWhateverTheLight) {
  const test::Waves texture = some_waves();
  GroundPicture ground({10, 8, 80, 60});
  for (int k = 0; k < 12; ++k) {
    // A part of another level at another place each time.
    const Circle hidden{20.0 + 5 * k, 40, 9};
    Picture picture = frame_of(texture, circling(k), k > 0 ? 1 + 0.1 * std::sin(k) : 1);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (std::hypot(x - hidden.x, y - hidden.y) < 2) picture.at(x, y) = 200;
    ground.add(picture, 0, 0, circling(k), hidden);
  }
  ground.finish(1e-4);
  constexpr int n = 40;
  std::vector<float> level(n * n), variance(n * n), slope_x(n * n), slope_y(n * n);
  const double x0 = 30.37, y0 = 20.81;
  ground.sample(x0, y0, n, n, level.data(), variance.data(), slope_x.data(), slope_y.data());
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const std::size_t at = static_cast<std::size_t>(j * n + i);
      const double x = x0 + i, y = y0 + j, h = 1e-4;
      ASSERT_NEAR(level[at] + ground.mean(), 70 + texture(x, y), 0.03);
      ASSERT_NEAR(slope_x[at], (texture(x + h, y) - texture(x - h, y)) / (2 * h), 0.05);
      ASSERT_NEAR(slope_y[at], (texture(x, y + h) - texture(x, y - h)) / (2 * h), 0.05);
    }
  EXPECT_LT(ground.unrest(), 0.01);
  double mean = 0, square = 0;
  for (int y = 8; y < 68; ++y)
    for (int x = 10; x < 90; ++x) {
      mean += texture(x, y) / (80 * 60);
      square += std::pow(texture(x, y), 2) / (80 * 60);
    }
  EXPECT_NEAR(ground.mean(), 70 + mean, 0.1);
  EXPECT_NEAR(ground.texture(), std::sqrt(square - mean * mean), 0.05);
}

TEST(GroundPicture, VarianceIsTheNoisesOverTheFrames) {
  constexpr double kNoise = 2;
  constexpr int kFrames = 64;
  std::mt19937 random(7);
  std::normal_distribution<float> gauss(0, kNoise);
  const test::Waves texture = some_waves();
  GroundPicture ground({0, 0, kWidth, kHeight});
  for (int k = 0; k < kFrames; ++k) {
    Picture picture = frame_of(texture, {});
    for (float& level : picture.levels()) level += gauss(random);
    // Half the frames hide the right half.
    ground.add(picture, 0, 0, {}, k % 2 == 0 ? kNothing : Circle{1040, 40, 990});
  }
  ground.finish(kNoise * kNoise);
  EXPECT_NEAR(ground.unrest(), kNoise * kNoise, 0.1);
  EXPECT_NEAR(ground.texture(), 6, 0.3);
  double square[2] = {}, told[2] = {};
  for (int y = 10; y < 70; ++y)
    for (int x = 10; x < 40; ++x)
      for (const int right : {0, 1}) {
        const int at = x + 50 * right;
        square[right] += std::pow(level_at(ground, at, y) - 70 - texture(at, y), 2) / 1800;
        told[right] += static_cast<double>(ground.variance().at(at, y)) / 1800;
      }
  for (const int right : {0, 1}) {
    const double expected = kNoise * kNoise / (kFrames / (right + 1.0));
    EXPECT_NEAR(square[right], expected, 0.15 * expected);
    // The larger of a place's own and its surroundings' scatter.
    EXPECT_GT(told[right], expected);
    EXPECT_LT(told[right], 1.2 * expected);
  }
}

TEST(GroundPicture, WhatWasNeverUncoveredIsUnknown) {
  const test::Waves texture = some_waves();
  GroundPicture ground({0, 0, kWidth, kHeight});
  for (int k = 0; k < 5; ++k) ground.add(frame_of(texture, {}), 0, 0, {}, {50, 40, 10});
  ground.finish(1);
  const auto unknown = static_cast<float>(std::pow(ground.texture(), 2));
  EXPECT_GT(unknown, 20);
  EXPECT_EQ(ground.variance().at(50, 40), unknown);
  EXPECT_EQ(ground.variance().at(58, 40), unknown);
  // Seen five times: the posterior of a place that scatters by the texture, and by the noise of 1 when seen.
  const float known = unknown / (5 * unknown + 1);
  EXPECT_NEAR(ground.variance().at(63, 40), known, 1e-6);
  EXPECT_NEAR(level_at(ground, 50, 40), ground.mean(), 1e-3);
  // Beyond the region it is as at its border.
  std::vector<float> level(4), variance(4);
  ground.sample(-20, 30, 2, 2, level.data(), variance.data());
  EXPECT_NEAR(variance[0], known, 1e-6);
}

// The level of least mean square error, and its error: by 4000 places of independent levels.
TEST(GroundPicture, WhatWasSeenOnceIsTakenForWhatItTells) {
  constexpr float kNoise = 4, kTexture = 6;
  std::mt19937 random(9);
  std::normal_distribution<float> gauss(0, 1);
  Picture truth(kWidth, kHeight, 70);
  for (float& level : truth.levels()) level += kTexture * gauss(random);
  GroundPicture ground({0, 0, kWidth, kHeight});
  for (int k = 0; k < 6; ++k) {
    Picture picture = truth;
    for (float& level : picture.levels()) level += kNoise * gauss(random);
    // The left half is uncovered in every frame, the right half in one.
    ground.add(picture, 0, 0, {}, k != 3 ? Circle{1049.5, 40, 1000} : kNothing);
  }
  ground.finish(kNoise * kNoise);
  const double once = kTexture * kTexture * kNoise * kNoise / (kTexture * kTexture + kNoise * kNoise);
  double square = 0, told = 0, n = 0;
  for (int y = 2; y < kHeight - 2; ++y)
    for (int x = 54; x < kWidth - 2; ++x, ++n) {
      square += std::pow(level_at(ground, x, y) - static_cast<double>(truth.at(x, y)), 2);
      told += static_cast<double>(ground.variance().at(x, y));
    }
  EXPECT_NEAR(square / n, once, 0.1 * once);
  EXPECT_NEAR(told / n, once, 0.15 * once);
}

TEST(GroundPicture, WrongDisplacementsShowAsUnrest) {
  const test::Waves texture = some_waves();
  GroundPicture ground({0, 0, kWidth, kHeight});
  for (int k = 0; k < 12; ++k) ground.add(frame_of(texture, circling(k)), 0, 0, {}, kNothing);
  ground.finish(1);
  EXPECT_GT(ground.unrest(), 5);
}

TEST(GroundPicture, WhatCrossesItIsHeldOut) {
  const test::Waves texture = some_waves();
  const auto crossed = [&](int k) {
    Picture picture = frame_of(texture, {}, 1 + 0.05 * std::sin(k));
    for (int y = 0; y < kHeight; ++y)
      for (int x = 8 * k; x < 8 * k + 10; ++x) picture.at(x, y) = 160;
    return picture;
  };
  GroundPicture ground({0, 0, kWidth, kHeight});
  for (int k = 0; k < 10; ++k) ground.add(crossed(k), 0, 0, {}, kNothing);
  ground.finish(1);
  EXPECT_GT(std::abs(level_at(ground, 43, 40) - 70 - texture(43, 40)), 5);
  EXPECT_EQ(ground.held_share(), 1);
  ground.hold_to(frame_of(texture, {}), 5);
  for (int k = 0; k < 10; ++k) ground.add(crossed(k), 0, 0, {}, kNothing);
  ground.finish(1);
  // Nine frames of noise 1 draw a place to the mean by one part in 9 * 36, the furthest by 0.076.
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) ASSERT_NEAR(level_at(ground, x, y), 70 + texture(x, y), 0.08);
  EXPECT_NEAR(ground.held_share(), 0.9, 1e-6);
  EXPECT_NEAR(ground.variance().at(43, 40), 1.0 / 9, 0.02);
  EXPECT_LT(ground.unrest(), 1e-3);
}

// Ground that a part at rest always hides, seen in its shadow: the level of the ground, not of the shadow,
// and alpha^2 of a frame counts.
TEST(GroundPicture, IsSeenBesideThePart) {
  PartByHand part;
  part.shadow = 0.25;
  LayeredState s;
  s.centre = {90.3, 64.6};
  const double hidden = part.half - 3.5;
  std::mt19937 random(2);
  std::vector<KeptWindow> windows;
  GroundPicture ground(PartByHand::region);
  constexpr int kFrames = 20;
  Picture picture(PartByHand::region.width, PartByHand::region.height);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) picture.at(x, y) = static_cast<float>(part.ground_level(x, y));
  for (int k = 0; k < kFrames; ++k) {
    ground.add(picture, 0, 0, {}, {s.centre.x, s.centre.y, hidden});
    s.gain = 1 + 0.05 * std::sin(k);
    s.ground_gain = 1 + 0.05 * std::cos(2.0 * k);
    windows.push_back(part.window(s, part.half + 6, 0, random));
  }
  constexpr double kNoise = 0.5;
  ground.finish(kNoise);
  const auto unknown = static_cast<float>(std::pow(ground.texture(), 2));
  // The model's mean is that of the ground's picture, here without what is hidden.
  PartPictures pictures = part.pictures(1);
  for (std::size_t i = 0; i < pictures.level.levels().size(); ++i)
    pictures.level.levels()[i] += pictures.share.levels()[i] * static_cast<float>(ground.mean() - part.mean);
  const auto at = [&](int u, int v) { return Point{std::round(s.centre.x + u), std::round(s.centre.y + v)}; };
  const Point in_shadow = at(24, 0), above = at(0, -25), under = at(5, 5);
  for (const Point& p : {in_shadow, above})
    EXPECT_EQ(ground.variance().at(static_cast<int>(p.x), static_cast<int>(p.y)), unknown);
  ground.see_beside(test::pointers_to(windows), pictures, hidden, kNoise);
  for (const Point& p : {in_shadow, above}) {
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    const double share = part.share(p.x - s.centre.x, p.y - s.centre.y);
    EXPECT_NEAR(level_at(ground, x, y), part.ground_level(x, y), 0.05);
    EXPECT_NEAR(ground.variance().at(x, y), kNoise / (kFrames * share * share), 0.02 * kNoise / kFrames);
  }
  EXPECT_LT(part.share(in_shadow.x - s.centre.x, in_shadow.y - s.centre.y), 0.8);
  EXPECT_EQ(ground.variance().at(static_cast<int>(under.x), static_cast<int>(under.y)), unknown);
  // A second look takes the first one's place.
  const float before = ground.variance().at(static_cast<int>(above.x), static_cast<int>(above.y));
  ground.see_beside(test::pointers_to(windows), pictures, hidden, kNoise, 3);
  EXPECT_EQ(ground.variance().at(static_cast<int>(above.x), static_cast<int>(above.y)), before);
}

}  // namespace
}  // namespace tribotrack::vision
