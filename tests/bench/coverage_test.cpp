// 95 % intervals hold the truth at their rate, for every design.
#include "apps/bench/coverage.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "apps/bench/peers.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

TEST(QuotedInterval, HoldsModuloATurnAndInAnyOfItsPieces) {
  const double turn = 2 * std::numbers::pi;
  EXPECT_TRUE(holds({{1, 2}}, 1.5 + 3 * turn, true));
  EXPECT_TRUE(holds({{1, 2}}, 1.5 - turn, true));
  EXPECT_FALSE(holds({{1, 2}}, 2.25, true));
  EXPECT_FALSE(holds({{1, 2}}, 0.75 - 2 * turn, true));
  EXPECT_FALSE(holds({{1, 2}}, 1.5 + turn, false));
  EXPECT_TRUE(holds({{0, 1}, {3, 4}}, 3.5, false));
  EXPECT_FALSE(holds({{0, 1}, {3, 4}}, 1.5, false));
  EXPECT_TRUE(holds({{0.1, HUGE_VAL}}, 0.2, false));
  EXPECT_FALSE(holds({{NAN, NAN}}, 1, false));
}

TEST(BinomialInterval, IsClopperAndPearsons) {
  // Tables: 95 of 100, 0 of 10.
  EXPECT_NEAR(binomial_ci95(95, 100).low, 0.8872, 1e-4);
  EXPECT_NEAR(binomial_ci95(95, 100).high, 0.9836, 1e-4);
  EXPECT_EQ(binomial_ci95(0, 10).low, 0);
  EXPECT_NEAR(binomial_ci95(0, 10).high, 0.3085, 1e-4);
  EXPECT_EQ(binomial_ci95(10, 10).high, 1);
}

TEST(CoverageCampaigns, AreThoseOfAnIndependentIntegratorAndHideTheTruth) {
  for (const Design design : {Design::five_runs, Design::sticking_with_tilt}) {
    const CoverageCampaign campaign = draw_campaign(design, NoiseLevel::low, 9, 3);
    EXPECT_EQ(campaign.truth, draw_campaign(design, NoiseLevel::low, 9, 3).truth);
    double chi2 = 0;
    for (const SummaryRun& run : campaign.problem.summary_runs) {
      model::Scenario truth = run.scenario;
      EXPECT_EQ(truth.friction.nominal, 0.05);
      EXPECT_EQ(truth.friction.lag, 0);
      EXPECT_EQ(truth.drive.tilt_x, 0);
      truth.friction.nominal = campaign.truth[0];
      truth.friction.reduced = campaign.truth[1];
      truth.friction.lag = campaign.truth[2];
      if (campaign.truth.size() > 3) {
        truth.drive.tilt_x = campaign.truth[3];
        truth.drive.tilt_y = campaign.truth[4];
      }
      const Eigen::Vector2d exact = extended_precision_reference(truth, 1e-11).position;
      const Eigen::Vector2d off = run.measured.vector - exact;
      chi2 += off.dot(run.measured.covariance.llt().solve(off));
    }
    const double dof = 2.0 * static_cast<double>(campaign.problem.summary_runs.size());
    EXPECT_GT(chi2, 0.2 * dof) << to_string(design);
    EXPECT_LT(chi2, 2.5 * dof) << to_string(design);
    EXPECT_TRUE(campaign.problem.start.empty());
  }
}

}  // namespace
}  // namespace tribotrack::bench
