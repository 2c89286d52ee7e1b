#include "apps/bench/fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "apps/bench/campaigns.h"
#include "fit/estimate.h"
#include "fit/prediction.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

TEST(SimulatedCampaign, ScattersByWhatItStates) {
  const FitTruth truth{0.1, 0.0125, 0.2};
  const Problem problem = simulated_campaign(truth, 5, 5);
  ASSERT_EQ(problem.summary_runs.size(), 14u);
  double chi2 = 0;
  for (const SummaryRun& run : problem.summary_runs) {
    const Eigen::Vector2d off = run.measured.vector - modelled_displacement(run.scenario);
    chi2 += off.dot(run.measured.covariance.inverse() * off);
  }
  // 28 degrees of freedom: within 4 standard deviations.
  EXPECT_NEAR(chi2, 28, 4 * std::sqrt(56.0));
}

TEST(FitBench, QuickRunComparesTheMethodsAtOneMinimum) {
  FitBenchOptions options;
  options.quick = true;
  const auto rows = bench_fit(options).rows;
  ASSERT_EQ(rows.size(), 8u);
  EXPECT_EQ(rows[0].method, "tribotrack");
  EXPECT_EQ(rows[0].at("off_minimum_sd"), 0);
  // Exact derivatives and good differences come to the same minimum, another implementation of it all.
  for (const std::size_t k : {0u, 1u, 2u, 3u, 4u}) EXPECT_TRUE(rows[k].arrived) << rows[k].method;
  EXPECT_LT(rows[3].at("solves"), rows[4].at("solves"));
  EXPECT_LT(rows[0].error, 0.1);
}

/// The least chi^2 of 40 campaigns of 3 to 14 runs at random, by looking everywhere: descents from all lowest
/// points of a grid over the whole box, from around the best end, and a compass search.
constexpr double kLeast[] = {3.06986,  6.10482,  3.10502,  17.49523, 9.00816,  12.90814, 9.15321,  17.56940,
                             14.80874, 19.37004, 22.08307, 14.94625, 1.67561,  8.91867,  5.81362,  7.58037,
                             6.27314,  12.79902, 11.69978, 8.65791,  11.69818, 15.37695, 38.50122, 15.94962,
                             6.28536,  8.07379,  7.62437,  5.36366,  15.60372, 10.53089, 9.52629,  14.49043,
                             15.56642, 17.07789, 15.57306, 22.54216, 3.62779,  2.69837,  8.05453,  4.28286};

TEST(Search, FindsTheGlobalMinimumOfFortyCampaigns) {
  FitOptions search_alone;
  search_alone.profiles = search_alone.next_experiment = search_alone.estimate_scatter = false;
  for (int k = 0; k < static_cast<int>(std::size(kLeast)); ++k) {
    const NoiseLevel level = k / 12 % 2 == 0 ? NoiseLevel::low : NoiseLevel::high;
    const Problem problem = draw_random_runs(3 + k % 12, level, 20210702, k).problem;
    EXPECT_NEAR(estimate(problem, search_alone).chi2_before_scatter, kLeast[k], 0.01) << "campaign " << k;
  }
}

}  // namespace
}  // namespace tribotrack::bench
