#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "fit/measurement.h"

namespace tribotrack::fit {
namespace {

/// A part on a platform of 10 Hz, carried along and sliding by turns: its acceleration jumps at each change.
struct Film {
  std::vector<std::int64_t> frames;
  std::vector<Eigen::Vector2d> positions;
};

Film film(double rate, std::size_t count, double sd_x, double sd_y, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Film film;
  double slid = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double t = static_cast<double>(k) / rate, turn = 62.8 * t;
    slid += 5 * std::max(0.0, std::sin(turn)) / rate;
    film.frames.push_back(static_cast<std::int64_t>(k));
    film.positions.emplace_back(0.28 * std::cos(turn) + slid + sd_x * normal(random),
                                -0.28 * std::sin(turn) - 0.5 * slid + sd_y * normal(random));
  }
  return film;
}

TEST(PointNoise, IsTheScatterOfEachCoordinate) {
  for (const double rate : {250.0, 500.0, 1000.0}) {
    const Film f = film(rate, 1000, 0.003, 0.006, 5);
    const auto noise = point_noise(f.frames, f.positions);
    ASSERT_TRUE(noise) << rate;
    EXPECT_NEAR(noise->x() / 0.003, 1, 0.12) << rate;
    EXPECT_NEAR(noise->y() / 0.006, 1, 0.12) << rate;
  }
}

TEST(PointNoise, WithFewFramesToATurnItIsTooLargeRatherThanTooSmall) {
  const Film f = film(100, 1000, 0.003, 0.006, 5);
  const auto noise = point_noise(f.frames, f.positions);
  ASSERT_TRUE(noise);
  EXPECT_GT(noise->x() / 0.003, 0.88);
  EXPECT_LT(noise->x() / 0.003, 2);
}

TEST(PointNoise, LostFramesAndEverySecondFrameDoNotMatter) {
  const Film f = film(500, 2000, 0.004, 0.004, 6);
  Film kept;
  for (std::size_t k = 0; k < f.frames.size(); k += 2) {
    if (k % 200 == 0) continue;
    kept.frames.push_back(f.frames[k]);
    kept.positions.push_back(f.positions[k]);
  }
  const auto noise = point_noise(kept.frames, kept.positions);
  ASSERT_TRUE(noise);
  EXPECT_NEAR(noise->x() / 0.004, 1, 0.12);
}

TEST(PointNoise, TooFewFramesTellNothing) {
  const Film f = film(250, 29, 0.003, 0.003, 7);
  EXPECT_FALSE(point_noise(f.frames, f.positions));
  EXPECT_FALSE(point_noise({}, {}));
}

}  // namespace
}  // namespace tribotrack::fit
