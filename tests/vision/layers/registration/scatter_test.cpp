#include "vision/layers/layers.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>

namespace tribotrack::vision {
namespace {

constexpr std::size_t kClusters = 12;

/// Clusters that err independently by AR(1) noise: of sd (1, 2) times `sd`, a frame holding `stay` of the
/// last.
std::vector<ClusterPulls> autoregressive(std::size_t frames, double sd, double stay, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss;
  std::vector<Eigen::Vector2d> now(kClusters);
  const auto fresh = [&] { return Eigen::Vector2d(sd * gauss(random), 2 * sd * gauss(random)); };
  for (Eigen::Vector2d& x : now) x = fresh();
  std::vector<ClusterPulls> out;
  for (std::size_t k = 0; k < frames; ++k) {
    out.emplace_back();
    for (Eigen::Vector2d& x : now) {
      out.back().emplace_back(x.cast<float>());
      x = stay * x + std::sqrt(1 - stay * stay) * fresh();
    }
  }
  return out;
}

const Eigen::Array2d kNothingTaken = Eigen::Array2d::Zero();

// Of AR(1) noise 1 - rho of the variance changes from frame to frame; what stays, 1, rho, rho^2 ... from the
// next frame on, lasts for 1/2 + 1 / (1 - rho) frames. White noise beside it changes nothing of that.
TEST(RunScatter, WhatStaysAlikeIsSlow) {
  constexpr std::size_t kFrames = 40000;
  constexpr double kStay = 0.8, kSd = 0.01, kWhite = 0.015;
  std::vector<ClusterPulls> frames = autoregressive(kFrames, kSd, kStay, 3);
  const std::vector<ClusterPulls> white = autoregressive(kFrames, kWhite, 0, 4);
  for (std::size_t k = 0; k < kFrames; ++k)
    for (std::size_t c = 0; c < kClusters; ++c) frames[k][c] += white[k][c];
  const RunScatter s = run_scatter(frames, kNothingTaken);
  const double of_both = 0.5 * 5 * kClusters, ar = of_both * kSd * kSd, w = of_both * kWhite * kWhite;
  EXPECT_NEAR(s.white, w + (1 - kStay) * ar, 0.02 * (w + ar));
  EXPECT_NEAR(s.slow, kStay * ar, 0.03 * (w + ar));
  EXPECT_NEAR(s.slow_frames, 0.5 + 1 / (1 - kStay), 0.1 / (1 - kStay));
  EXPECT_NEAR(s.white + s.slow, 0.5 * s.covariance.trace(), 1e-9 * s.white);
}

TEST(RunScatter, WhatStaysForTheWholeRunIsNoError) {
  std::vector<ClusterPulls> frames = autoregressive(128, 0.01, 0.5, 5);
  const RunScatter without = run_scatter(frames, kNothingTaken);
  for (ClusterPulls& f : frames)
    for (std::size_t c = 0; c < kClusters; ++c) f[c] += Eigen::Vector2f(0.05F * static_cast<float>(c), -0.2F);
  const RunScatter with = run_scatter(frames, kNothingTaken);
  EXPECT_LT((with.covariance - without.covariance).norm(), 1e-4 * without.covariance.norm());
  EXPECT_NEAR(with.white, without.white, 1e-4 * without.white);
  EXPECT_NEAR(with.slow, without.slow, 1e-4 * without.white);
}

TEST(RunScatter, SquaresThePositionHasTakenAreGivenBack) {
  const std::vector<ClusterPulls> frames = autoregressive(128, 0.01, 0.5, 6);
  const RunScatter none = run_scatter(frames, kNothingTaken), some = run_scatter(frames, {0.19, 0.36});
  EXPECT_NEAR(some.covariance(0, 0), none.covariance(0, 0) / 0.81, 1e-12);
  EXPECT_NEAR(some.covariance(1, 1), none.covariance(1, 1) / 0.64, 1e-12);
  EXPECT_NEAR(some.covariance(0, 1), none.covariance(0, 1) / (0.9 * 0.8), 1e-12);
  EXPECT_NEAR(some.white, none.white / (1 - 0.275), 1e-12);
}

}  // namespace
}  // namespace tribotrack::vision
