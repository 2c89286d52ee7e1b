#include "apps/bench/comparison.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "fit/prediction.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

TEST(FitBench, QuickRunComparesTheMethodsAtOneMinimum) {
  const auto rows = bench_fit({.quick = true}).rows;
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[0].method, "tribotrack");
  EXPECT_EQ(rows[0].at("off_minimum_sd"), 0);
  // Good differences come to the same minimum, another implementation of it all.
  for (const std::size_t k : {0u, 1u, 2u}) EXPECT_TRUE(rows[k].arrived) << rows[k].method;
  EXPECT_LT(rows[0].error, 0.1);
}

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

}  // namespace
}  // namespace tribotrack::bench
