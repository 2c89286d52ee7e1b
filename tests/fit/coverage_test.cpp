// Do 95 % intervals of fits to displacements cover the truth in 95 % of campaigns? Hundreds of cheap
// campaigns: simulated once, noise drawn for each.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

/// Noise of their stated size.
void add_noise(Problem& problem, std::mt19937& random) {
  std::normal_distribution<double> normal;
  for (SummaryRun& run : problem.summary_runs) {
    const Eigen::Matrix2d root = run.measured.covariance.llt().matrixL();
    run.measured.vector += root * Eigen::Vector2d(normal(random), normal(random));
    derive_alpha_and_v(run.measured);
  }
}

/// The parameters of one campaign are correlated: each campaign is one trial, of one parameter after the
/// other. Wald's sequential probability ratio test of 95 % against 90 % and against 98 %, each decided with
/// errors of probability 0.01: some 300 trials do.
TEST(Coverage, OfDisplacementsIs95Percent) {
  constexpr unsigned kSeed = 11, kMostCampaigns = 3000;
  const test::Truth truth;
  const double truths[] = {truth.mu1, truth.mu2, truth.lag};
  Problem problem = test::problem_of(test::fourteen(truth), 0.01, 0.02e-3);
  // First guesses off the truth by many standard deviations.
  problem.start = {{FitParameter::mu1, 1.03 * truth.mu1},
                   {FitParameter::mu2, 1.5 * truth.mu2},
                   {FitParameter::lag, truth.lag + 0.1}};
  FitOptions options{.multi_starts = 1, .profiles = false, .next_experiment = false};
  const double bound = std::log(100);
  double too_low = 0, too_high = 0;  // log-likelihood ratios
  unsigned trials = 0;
  for (;
       trials < kMostCampaigns && std::max(too_low, too_high) > -bound && std::max(too_low, too_high) < bound;
       ++trials) {
    std::seed_seq mixed{kSeed, trials};
    std::mt19937 random(mixed);
    Problem noisy = problem;
    add_noise(noisy, random);
    const FitResult result = estimate(noisy, options);
    const Interval& ci95 = result.parameters[trials % 3].ci95;
    const bool covered = ci95.low <= truths[trials % 3] && truths[trials % 3] <= ci95.high;
    too_low += std::log(covered ? 0.90 / 0.95 : 0.10 / 0.05);
    too_high += std::log(covered ? 0.98 / 0.95 : 0.02 / 0.05);
  }
  EXPECT_LE(too_low, -bound) << trials << " trials";
  EXPECT_LE(too_high, -bound) << trials << " trials";
}

}  // namespace
}  // namespace tribotrack::fit
