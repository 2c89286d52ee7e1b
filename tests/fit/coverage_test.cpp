// Do 95 % intervals of fits to displacements cover the truth in 95 % of campaigns? Hundreds of cheap
// campaigns: simulated once, noise drawn for each.
#include "fit/coverage.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstdio>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"
#include "fit/tools/statistics.h"

namespace tribotrack::fit {
namespace {

using test::IntervalTrials;
using test::SequentialCoverage;
using Decision = SequentialCoverage::Decision;

constexpr int kMostCampaigns = 3000;

class Campaigns {
 public:
  /// `scatter`: m per axis beyond the sigmas given.
  explicit Campaigns(double scatter) : scatter_(scatter) {
    problem_.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
    // First guesses off the truth by many standard deviations.
    problem_.start = {{FitParameter::mu1, 1.03 * truth_.mu1},
                      {FitParameter::mu2, 1.5 * truth_.mu2},
                      {FitParameter::lag, truth_.lag + 0.1}};
    for (const auto& scenario : test::fourteen(truth_))
      problem_.summary_runs.push_back(test::summary_run(scenario, 0.01, 0.02e-3));
  }
  std::vector<double> truth() const { return {truth_.mu1, truth_.mu2, truth_.lag}; }

  FitResult fit(unsigned seed, int index) const {
    std::seed_seq mixed{seed, static_cast<unsigned>(index)};
    std::mt19937 random(mixed);
    std::normal_distribution<double> normal;
    Problem problem = problem_;
    for (auto& run : problem.summary_runs) {
      const Eigen::Matrix2d root =
          (run.measured.covariance + scatter_ * scatter_ * Eigen::Matrix2d::Identity()).llt().matrixL();
      run.measured.vector += root * Eigen::Vector2d(normal(random), normal(random));
      derive_alpha_and_v(run.measured);
    }
    FitOptions options;
    options.multi_starts = 1;
    options.profiles = options.next_experiment = false;
    return estimate(problem, options);
  }

 private:
  test::Truth truth_;
  double scatter_;
  Problem problem_;
};

/// The parameters of one campaign are correlated: each campaign is one trial, of one parameter after the
/// other. Intervals are stretched about their middle by `factor`.
Decision decide(const char* name, double scatter, double factor, unsigned seed) {
  const Campaigns campaigns(scatter);
  const std::vector<double> truth = campaigns.truth();
  SequentialCoverage coverage(0.01);
  std::array<IntervalTrials, 3> trials;
  for (int k = 0; k < kMostCampaigns && !coverage.decided(); ++k) {
    const FitResult result = campaigns.fit(seed, k);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const auto& p = result.parameters[i];
      const double middle = 0.5 * (p.ci95.low + p.ci95.high),
                   half = 0.5 * factor * (p.ci95.high - p.ci95.low);
      const Interval interval{middle - half, middle + half};
      trials[i].add(interval, p.estimate, truth[i]);
      if (static_cast<std::size_t>(k) % truth.size() == i)
        coverage.add(interval.low <= truth[i] && truth[i] <= interval.high);
    }
  }
  std::printf("%-22s x %.2f: %.1f %% of %d, score", name, factor, 100 * coverage.share(), coverage.trials);
  for (const auto& trial : trials) std::printf(" %.2f", trial.relative_score());
  std::printf(" (exact %.2f)\n", test::kNormalScore);
  std::fflush(stdout);
  if (factor == 1)
    for (const auto& trial : trials) {
      EXPECT_GT(trial.relative_score(), 0.9 * test::kNormalScore) << name;
      EXPECT_LT(trial.relative_score(), 1.12 * test::kNormalScore) << name;
    }
  return coverage.decision();
}

TEST(Coverage, OfDisplacementsIs95Percent) {
  const unsigned seed = 11;
  SCOPED_TRACE(seed);
  EXPECT_EQ(decide("sigma known", 0, 1, seed), Decision::nominal);
}

TEST(CoverageCampaign, DISABLED_OfDisplacementsThatScatterIs95Percent) {
  const unsigned seed = 11;
  SCOPED_TRACE(seed);
  EXPECT_EQ(decide("scatter between runs", 1e-4, 1, seed), Decision::nominal);
}

/// What the test above would see: intervals of 90 %, or wide enough for 99 %.
TEST(Coverage, OfWrongIntervalsIsSeen) {
  const unsigned seed = 12;
  SCOPED_TRACE(seed);
  const auto quantile = [](double p) { return internal::two_sided_quantile(p, HUGE_VAL); };
  EXPECT_EQ(decide("90 %", 0, quantile(0.90) / quantile(0.95), seed), Decision::too_low);
  EXPECT_EQ(decide("99 %", 0, quantile(0.99) / quantile(0.95), seed), Decision::too_high);
}

TEST(Coverage, ScoreIsLowestForTheTrueInterval) {
  const unsigned seed = 13;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::array<IntervalTrials, 4> trials;
  for (int k = 0; k < 20000; ++k) {
    const double estimate = normal(random);
    const double halves[] = {1.959964, 1.644854, 2.575829, HUGE_VAL};
    for (std::size_t i = 0; i < trials.size(); ++i)
      trials[i].add({estimate - halves[i], estimate + halves[i]}, estimate, 0);
  }
  EXPECT_NEAR(trials[0].relative_score(), test::kNormalScore, 0.1);
  EXPECT_GT(trials[1].relative_score(), trials[0].relative_score());
  EXPECT_GT(trials[2].relative_score(), trials[0].relative_score());
  EXPECT_EQ(trials[3].relative_score(), HUGE_VAL);
}

}  // namespace
}  // namespace tribotrack::fit
