// Tracks that say which of their errors neighbouring points share.
#include <gtest/gtest.h>

#include <random>

#include "fit/campaign.h"
#include "fit/slow_tracks.h"
#include "fit/variances/correlated_variances.h"
#include "fit/variances/excess_variance.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kWhite = 0.5e-6;         ///< m
constexpr SlowError kSlow{0.6e-6, 0.25};  ///< of tracks of 2 s

Problem drawn(int runs, double rate, std::mt19937& random) {
  const test::Truth truth;
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  problem.start = {
      {FitParameter::mu1, truth.mu1}, {FitParameter::mu2, truth.mu2}, {FitParameter::lag, truth.lag}};
  for (int k = 0; k < runs; ++k) {
    problem.trajectory_runs.push_back(
        test::slow_track(test::scenario(truth, 2.1 * k, 0.8 + 0.2 * (k % 3)), rate, kWhite, {}, random));
    test::add_slow(problem.trajectory_runs.back().track, kSlow, random);
  }
  return problem;
}

void keep_silent(Problem& problem) {
  for (TrajectoryRun& run : problem.trajectory_runs) run.track.slow.clear();
}

// What is told is not found again: neither as slow errors nor as scatter; kept silent, it is.
TEST(ToldErrors, AreNotCountedTwice) {
  const Eigen::Vector3d truth(0.1, 0.0125, 0.1);
  int told = 0, silent = 0;
  double scatter = 0, ratio = 0;
  const int trials = 8;
  for (int trial = 0; trial < trials; ++trial) {
    std::mt19937 random(7 + static_cast<unsigned>(trial));
    Problem problem = drawn(6, 60, random);
    for (const bool tells : {true, false}) {
      if (!tells) keep_silent(problem);
      const Unknowns unknowns(problem);
      Residuals residuals(unknowns);
      for (const double variance : estimate_correlated_errors(residuals, truth).variances)
        (tells ? told : silent) += variance > 0;
      if (!tells) continue;
      const auto at = residuals.at(truth, false);
      ASSERT_TRUE(at);
      ratio += at->chi2() / (static_cast<double>(residuals.layout().rows() - 12) * trials);
      for (const auto& run : estimate_excess_variance(residuals, truth, *at).trajectories)
        scatter = std::max(scatter, run.between_points);
    }
  }
  EXPECT_LE(told, 2);
  EXPECT_GE(silent, trials);
  EXPECT_EQ(scatter, 0);
  EXPECT_NEAR(ratio, 1, 0.06);  // 4 sd
}

}  // namespace
}  // namespace tribotrack::fit::internal
