#include "vision/audit/halves.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "vision/audit/synthetic_track.h"

namespace tribotrack::vision {
namespace {

using test::halves_of;
using test::kSigma;
using test::white;

/// Without nuisances the halves' disagreement is that of two fits of their own:
/// e' C^-1 e = D' Cov(D)^-1 D, D the difference of their positions.
TEST(Halves, WithoutNuisancesItIsTheDifferenceOfTheHalvesPositions) {
  std::mt19937 random(6);
  std::normal_distribution<> noise;
  Eigen::Matrix2d left = Eigen::Matrix2d::Zero(), right = left;
  Eigen::Vector2d left_force = Eigen::Vector2d::Zero(), right_force = left_force;
  std::vector<TileSums> tiles;
  for (int k = 0; k < 64; ++k) {
    TileSums tile;
    tile.place = {8.0 * (k % 8) - 28.5, 8.0 * (k / 8) - 28.5};
    const Eigen::Matrix2d slopes = Eigen::Matrix2d::NullaryExpr([&] { return noise(random); });
    const Eigen::Vector2d force(noise(random), noise(random));
    tile.normal = slopes * slopes.transpose();
    tile.score = force;
    (tile.place.x < 0 ? left : right) += slopes * slopes.transpose();
    (tile.place.x < 0 ? left_force : right_force) += force;
    tiles.push_back(tile);
  }
  const Eigen::Matrix2d normal = left + right;
  const Eigen::Vector2d found = normal.ldlt().solve(left_force + right_force);
  for (TileSums& tile : tiles) tile.score -= tile.normal * found;
  const Eigen::Vector2d e = halves_error(tiles, normal, normal.inverse())->left_right;
  const Eigen::Vector2d difference = left.inverse() * left_force - right.inverse() * right_force;
  const Eigen::Matrix2d of_difference = left.inverse() + right.inverse();
  EXPECT_NEAR(e.dot(normal * e), difference.dot(of_difference.inverse() * difference), 1e-9);
  // A half without information is no judge.
  std::erase_if(tiles, [](const TileSums& tile) { return tile.place.x < 0; });
  EXPECT_FALSE(halves_error(tiles, right, right.inverse()));
}

/// A first-order autoregression per component with this correlation from frame to frame.
class Drift {
 public:
  Drift(double sd, double correlation) : sd_(sd), correlation_(correlation) {}
  double at(std::int64_t frame, int component, std::mt19937& random) {
    State& s = states_[static_cast<std::size_t>(component)];
    if (s.frame < 0) s.value = white(random, sd_);
    for (; s.frame < frame; ++s.frame)
      if (s.frame >= 0)
        s.value = correlation_ * s.value + white(random, sd_ * std::sqrt(1 - correlation_ * correlation_));
    return s.value;
  }

 private:
  struct State {
    std::int64_t frame = -1;
    double value = 0;
  };
  double sd_, correlation_;
  std::array<State, 6> states_{};
};

TEST(HalvesOverTheRecording, WhiteNoiseAboutAConstantIsRight) {
  double total = 0, spread = 0, claimed = 0;
  int slow = 0;
  constexpr int kTrials = 200;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    const auto found =
        halves_found(halves_of(5000, seed, [](auto, int, std::mt19937& r) { return white(r); }));
    ASSERT_TRUE(found);
    total += found->total.value / kTrials;
    spread += std::pow(found->total.value - 1, 2) / kTrials;
    claimed += found->total.scatter / kTrials;
    slow += found->slow_frames > 0;
    EXPECT_NEAR(found->left_right, 1, 0.15);
    EXPECT_NEAR(found->unit, kSigma * kSigma, 1e-12);
  }
  EXPECT_NEAR(total, 1, 0.01);
  EXPECT_NEAR(std::sqrt(spread), 0.036, 0.006);  // sqrt(2 / 1530)
  EXPECT_NEAR(claimed / std::sqrt(spread), 1, 0.2);
  EXPECT_LE(slow, 3);  // one-sided three standard deviations
}

TEST(HalvesOverTheRecording, ASlowPartIsToldFromTheWhiteOne) {
  double white_part = 0, total = 0, spread = 0, claimed = 0, frames = 0;
  constexpr int kTrials = 100;
  constexpr double kCorrelation = 0.98;  // integral: 0.5 + 0.98 / 0.02 = 49.5 frames
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    Drift drift(kSigma, kCorrelation);
    const auto found = halves_found(halves_of(
        5000, seed, [&](std::int64_t k, int c, std::mt19937& r) { return white(r) + drift.at(k, c, r); }));
    ASSERT_GT(found->slow_frames, 0);
    white_part += found->white.value / kTrials;
    total += found->total.value / kTrials;
    frames += found->slow_frames / kTrials;
    spread += std::pow(found->total.value - 2, 2) / kTrials;
    claimed += found->total.scatter / kTrials;
  }
  // That of 32 independent runs of 6 numbers, not of 256 frames.
  EXPECT_GT(std::sqrt(spread), 0.08);
  EXPECT_NEAR(claimed / std::sqrt(spread), 1, 0.25);
  EXPECT_NEAR(white_part, 1 + (1 - kCorrelation), 0.04);
  EXPECT_NEAR(total, 2, 0.1);
  EXPECT_GT(frames, 20);
  EXPECT_LT(frames, 150);
}

TEST(HalvesOverTheRecording, ErrorsThatAlternateAreNotTakenForTwice) {
  const auto found = halves_found(halves_of(200, 3, [](std::int64_t k, int, std::mt19937& r) {
    return (k % 2 == 0 ? 2 : -2) * kSigma + white(r, 0.1 * kSigma);
  }));
  EXPECT_NEAR(found->white.value, 4, 0.2);
  EXPECT_EQ(found->slow_frames, 0);
}

TEST(HalvesOverTheRecording, FewFramesTellNothing) {
  EXPECT_FALSE(halves_found(halves_of(15, 1, [](auto, int, std::mt19937& r) { return white(r); })));
}

}  // namespace
}  // namespace tribotrack::vision
