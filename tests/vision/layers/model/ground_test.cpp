#include "vision/layers/model/ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

/// Frames of a moving texture, point samples: exact values exist everywhere.
Picture frame_of(const test::Waves& texture, const Point& p, int width, int height, double light = 1) {
  Picture out(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      out.at(x, y) = static_cast<float>(light * (70 + texture(x - p.x, y - p.y)));
  return out;
}

TEST(GroundPicture, IsThePlatformInItsOwnFrameWhateverTheLight) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random(kSeed);
  const test::Waves texture = test::random_waves(random, 12, 8, 6);
  GroundPicture ground({10, 8, 80, 60});
  for (int k = 0; k < 12; ++k) {
    const Point p{2.7 * std::cos(0.5 * k), 2.7 * std::sin(0.5 * k)};
    // A disc hides another place each time.
    const Circle hidden{20.0 + 5 * k, 40, 9};
    Picture picture = frame_of(texture, p, 100, 80, 1 + (k > 0 ? 0.1 * std::sin(k) : 0));
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 100; ++x)
        if (std::hypot(x - hidden.x, y - hidden.y) < 5) picture.at(x, y) = 200;
    ground.add(picture, 0, 0, p, hidden);
  }
  ground.finish(1);
  constexpr int n = 30;
  std::vector<float> value(n * n), known(n * n);
  const double x0 = 30.37;
  const double y0 = 20.81;
  ground.sample(x0, y0, n, n, value.data(), known.data());
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      EXPECT_EQ(known[j * n + i], 1);
      EXPECT_NEAR(value[j * n + i], 70 + texture(x0 + i, y0 + j), 0.15);
    }
  EXPECT_LT(ground.unrest(), 0.01);
  EXPECT_NEAR(ground.mean(), 70, 3);
}

TEST(GroundPicture, WhatWasNeverUncoveredIsUnknown) {
  GroundPicture ground({0, 0, 60, 60});
  for (int k = 0; k < 5; ++k) ground.add(Picture(60, 60, 70), 0, 0, {}, {30, 30, 10});
  ground.finish(1);
  std::vector<float> value(60 * 60), known(60 * 60);
  ground.sample(0, 0, 60, 60, value.data(), known.data());
  EXPECT_EQ(known[30 * 60 + 30], 0);
  EXPECT_EQ(known[30 * 60 + 22], 0);
  EXPECT_EQ(known[30 * 60 + 15], 1);
  for (const float v : value) EXPECT_NEAR(v, 70, 1e-3);  // continued smoothly
}

TEST(GroundPicture, WrongDisplacementsShowAsUnrest) {
  std::mt19937 random(6);
  const test::Waves texture = test::random_waves(random, 12, 8, 6);
  GroundPicture ground({0, 0, 80, 60});
  for (int k = 0; k < 12; ++k)
    ground.add(frame_of(texture, {2.7 * std::cos(0.5 * k), 0}, 80, 60), 0, 0, {}, {40, 30, 5});
  ground.finish(1);
  EXPECT_GT(ground.unrest(), 5);
}

}  // namespace
}  // namespace tribotrack::vision
