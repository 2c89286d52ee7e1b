// The fit finds the global minimum, which looking everywhere knows.
#include "apps/bench/fit/exhaustive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <thread>

#include "apps/bench/fit/designs.h"
#include "fit/estimate.h"
#include "fit/prediction.h"

namespace tribotrack::bench {
namespace {

void print(const SearchOutcome& outcome) {
  const auto& [index, runs, found, least] = outcome;
  std::printf("campaign %d, %d runs: fit %.4f at (%.5g, %.5g, %.4g), exhaustive %.4f at (%.5g, %.5g, %.4g)\n",
              index, runs, found.chi2, found.at.mu1, found.at.mu2, found.at.lag, least.chi2, least.at.mu1,
              least.at.mu2, least.at.lag);
}

TEST(ExhaustiveMinimum, IsNotAboveTheTruthAndStationary) {
  const CoverageCampaign campaign = draw_random_runs(3, NoiseLevel::low, 20210702, 0);
  const ExhaustiveMinimum least = exhaustive_minimum(campaign.problem, 0);
  EXPECT_GT(least.descents, 1);
  const auto chi2 = [&](double mu1, double mu2, double lag) {
    double sum = 0;
    for (const fit::SummaryRun& run : campaign.problem.summary_runs) {
      model::Scenario s = run.scenario;
      s.friction.nominal = mu1;
      s.friction.reduced = mu2;
      s.friction.lag = lag;
      const Eigen::Vector2d off = run.measured.vector - fit::modelled_displacement(s);
      sum += off.dot(run.measured.covariance.llt().solve(off));
    }
    return sum;
  };
  EXPECT_NEAR(chi2(least.at.mu1, least.at.mu2, least.at.lag), least.chi2, 1e-6);
  EXPECT_LE(least.chi2, chi2(campaign.truth[0], campaign.truth[1], campaign.truth[2]));
  for (const double by : {-1e-3, 1e-3}) {
    EXPECT_GE(chi2(least.at.mu1 * (1 + by), least.at.mu2, least.at.lag), least.chi2);
    EXPECT_GE(chi2(least.at.mu1, least.at.mu2 * (1 + by), least.at.lag), least.chi2);
    EXPECT_GE(chi2(least.at.mu1, least.at.mu2, least.at.lag + by), least.chi2);
  }
}

/// chi^2 of the exhaustive search of campaigns 0 to 39 of SearchBenchOptions (the campaign below finds them
/// anew), 3 to 14 runs.
constexpr double kLeast[] = {3.06986,  6.10482,  3.10502,  17.49523, 9.00816,  12.90814, 9.15321,  17.56940,
                             14.80874, 19.37004, 22.08307, 14.94625, 1.67561,  8.91867,  5.81362,  7.58037,
                             6.27314,  12.79902, 11.69978, 8.65791,  11.69818, 15.37695, 38.50122, 15.94962,
                             6.28536,  8.07379,  7.62437,  5.36366,  15.60372, 10.53089, 9.52629,  14.49043,
                             15.56642, 17.07789, 15.57306, 22.54216, 3.62779,  2.69837,  8.05453,  4.28286};

TEST(Search, FindsTheGlobalMinimumOfFortyCampaigns) {
  int missed = 0;
  for (int k = 0; k < static_cast<int>(std::size(kLeast)); ++k) {
    const CoverageCampaign campaign = search_campaign({}, k);
    const double found = minimum_of_fit(campaign.problem).chi2;
    const double least = kLeast[k];
    EXPECT_GT(found, least - 0.01) << "campaign " << k << ": lower than by exhaustive search";
    missed += found > least + 0.01;
    if (found > least + 0.01) std::printf("campaign %d: %.4f for %.4f\n", k, found, least);
  }
  EXPECT_EQ(missed, 0);
}

/// Of a thousand campaigns of 3 to 14 runs one minimum is missed at most.
TEST(SearchCampaign, DISABLED_MissesOneMinimumOfAThousandAtMost) {
  SearchBenchOptions options;
  options.threads = static_cast<int>(std::thread::hardware_concurrency());
  std::printf("seed %llu\n", static_cast<unsigned long long>(options.seed));
  int missed = 0, better = 0;
  for (const SearchOutcome& outcome : search_outcomes(options)) {
    missed += outcome.missed();
    better += outcome.better();
    if (outcome.missed() || outcome.better()) print(outcome);
    if (outcome.index < static_cast<int>(std::size(kLeast))) {
      EXPECT_NEAR(outcome.least.chi2, kLeast[outcome.index], 0.01) << "campaign " << outcome.index;
    }
  }
  std::printf("%d missed, %d lower than by exhaustive search\n", missed, better);
  EXPECT_LE(missed, 1);
  EXPECT_LE(better, 1);
}

}  // namespace
}  // namespace tribotrack::bench
