#include "vision/layers/model/ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

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

}  // namespace
}  // namespace tribotrack::vision
