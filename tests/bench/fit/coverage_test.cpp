// 95 % intervals hold the truth at their rate, for every design.
#include "apps/bench/fit/coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <thread>

#include "fit/coverage.h"
#include "fit/estimate.h"
#include "fit/slow_friction.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace fit;
using test::SequentialCoverage;

namespace {

void print(const CoverageRow& row) {
  const Interval range = row.share_ci95();
  std::printf("%-22s %-4s %-14s %4d: %4d usable (%d weak, %d open): %.1f %% [%.1f, %.1f], score %.2f\n",
              to_string(row.design), to_string(row.level), row.parameter.c_str(), row.campaigns, row.usable,
              row.weak, row.open, 100 * row.share(), 100 * range.low, 100 * range.high, row.score);
}

TEST(QuotedInterval, IsJudgedModuloATurnAndByItsPieces) {
  const double turn = 2 * std::numbers::pi;
  EXPECT_EQ(outside({1, 2}, 1.5 + 3 * turn, true), 0);
  EXPECT_EQ(outside({1, 2}, 1.5 - turn, true), 0);
  EXPECT_NEAR(outside({1, 2}, 2.25, true), 0.25, 1e-15);
  EXPECT_NEAR(outside({1, 2}, 0.75 - 2 * turn, true), 0.25, 1e-14);
  EXPECT_EQ(outside({1, 2}, 1.5 + turn, false), turn - 0.5);
  EXPECT_EQ(outside({NAN, NAN}, 1, false), HUGE_VAL);

  const JudgedInterval two = judge_pieces({{0, 1}, {3, 4}}, 3.5, 1, false),
                       between = judge_pieces({{0, 1}, {3, 4}}, 1.5, 1, false);
  EXPECT_TRUE(two.holds);
  EXPECT_NEAR(two.score, 2 / kNormalScore, 1e-12);
  EXPECT_FALSE(between.holds);
  EXPECT_NEAR(between.score, (2 + 40 * 0.5) / kNormalScore, 1e-12);
  const JudgedInterval open = judge_pieces({{0.1, HUGE_VAL}}, 0.2, 1, false);
  EXPECT_TRUE(open.open && open.holds);
  EXPECT_EQ(open.score, kWorstScore);
  EXPECT_TRUE(judge_pieces({{-std::numbers::pi, std::numbers::pi}}, 0, 1, true).open);
  EXPECT_FALSE(judge_pieces({{NAN, NAN}}, 0, 1, false).holds);
}

TEST(QuotedInterval, TheExactIntervalScoresOne) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  double exact = 0, narrow = 0, wide = 0;
  constexpr int kTrials = 40000;
  for (int k = 0; k < kTrials; ++k) {
    const double estimate = 7 * normal(random);
    const auto score = [&](double half) {
      return judge_pieces({{estimate - 7 * half, estimate + 7 * half}}, 0, 7, false).score / kTrials;
    };
    exact += score(1.959964);
    narrow += score(1.6);
    wide += score(2.4);
  }
  EXPECT_NEAR(exact, 0.994, 0.015);  // cut at kWorstScore
  EXPECT_GT(narrow, exact + 0.01);
  EXPECT_GT(wide, exact + 0.01);
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
      const Eigen::Vector2d exact = test::SlowFriction(truth).displacement(2000);
      const Eigen::Vector2d off = run.measured.vector - exact;
      chi2 += off.dot(run.measured.covariance.llt().solve(off));
    }
    const double dof = 2.0 * static_cast<double>(campaign.problem.summary_runs.size());
    EXPECT_GT(chi2, 0.2 * dof) << to_string(design);
    EXPECT_LT(chi2, 2.5 * dof) << to_string(design);
    EXPECT_TRUE(campaign.problem.start.empty());
  }
}

TEST(CoverageCampaigns, DependOnTheirArgumentsAlone) {
  for (const Design design : kDesigns) {
    const CoverageCampaign one = draw_campaign(design, NoiseLevel::high, 5, 2),
                           same = draw_campaign(design, NoiseLevel::high, 5, 2),
                           other = draw_campaign(design, NoiseLevel::high, 5, 3);
    EXPECT_EQ(one.truth, same.truth);
    EXPECT_EQ(one.bound, same.bound);
    EXPECT_NE(one.truth, other.truth);
    ASSERT_EQ(one.bound.size(), one.problem.free.size());
    for (std::size_t i = 0; i < one.bound.size(); ++i) {
      EXPECT_GT(one.bound[i], 0) << to_string(design);
      EXPECT_LT(one.bound[i], 10) << to_string(design);
    }
  }
}

/// Misses of the three parameters of one fit are correlated by 0.2 to 0.6: they are worth some 1.7
/// independent trials.
constexpr double kWeight = 0.5;
/// Campaigns that tell 90 % from 95 %: see the second test.
constexpr std::size_t kMost = 100;

/// Campaigns of the designs that are fitted fast, in turn, at both levels, until 95 % are told from 90 and
/// from 98 %, or 90 % would have been seen.
SequentialCoverage sequential(double stretch, std::uint64_t seed) {
  constexpr std::array kQuick{Design::three_runs, Design::slides, Design::five_runs};
  SequentialCoverage coverage(0.05);
  for (std::size_t k = 0; k < kMost && !coverage.decided(); ++k) {
    const CoverageCampaign campaign = draw_campaign(
        kQuick[k % kQuick.size()], kNoiseLevels[k / kQuick.size() % 2], seed, static_cast<int>(k));
    FitOptions options;
    options.next_experiment = false;
    const FitResult result = estimate(campaign.problem, options);
    if (!result.usable()) continue;
    const std::size_t count = campaign.truth.size();
    for (std::size_t i = 0; i < count; ++i) {
      const ParameterEstimate& p = result.parameters[i];
      auto pieces = quoted_pieces(p);
      for (Interval& piece : pieces)
        piece = {p.estimate + stretch * (piece.low - p.estimate),
                 p.estimate + stretch * (piece.high - p.estimate)};
      const bool turns = p.parameter == FitParameter::lag;
      coverage.add(judge_pieces(pieces, campaign.truth[i], campaign.bound[i], turns).holds,
                   count > 1 ? kWeight : 1);
    }
  }
  return coverage;
}

TEST(Coverage, OfQuickDesignsIs95Percent) {
  const std::uint64_t seed = 21;
  SCOPED_TRACE(seed);
  const SequentialCoverage coverage = sequential(1, seed);
  std::printf("%d of %d hold\n", coverage.hits, coverage.trials);
  EXPECT_NE(coverage.decision(), SequentialCoverage::Decision::too_low);
  EXPECT_NE(coverage.decision(), SequentialCoverage::Decision::too_high);
}

/// What the test above would see.
TEST(Coverage, OfNinetyPercentIsSeen) {
  const std::uint64_t seed = 22;
  SCOPED_TRACE(seed);
  const SequentialCoverage coverage = sequential(1.644854 / 1.959964, seed);
  std::printf("%d of %d hold\n", coverage.hits, coverage.trials);
  EXPECT_EQ(coverage.decision(), SequentialCoverage::Decision::too_low);
}

/// 2000 campaigns of each design and level: all of a coverage's 95 % range outside 93 to 97 % fails.
TEST(CoverageCampaign, DISABLED_OfEveryDesignIsBetween93And97Percent) {
  CoverageOptions options;
  options.campaigns = options.of_trajectories = 2000;
  options.threads = static_cast<int>(std::thread::hardware_concurrency());
  std::printf("seed %llu\n", static_cast<unsigned long long>(options.seed));
  for (const CoverageRow& row : coverage_of(judged_campaigns(options))) {
    print(row);
    const Interval range = row.share_ci95();
    const std::string where =
        std::string(to_string(row.design)) + ", " + to_string(row.level) + " noise, " + row.parameter;
    EXPECT_GE(range.high, 0.93) << where;
    EXPECT_LE(range.low, 0.97) << where;
    // Half the campaigns of a sweep of phi alone at high noise cannot tell mu1 from the lag.
    EXPECT_GT(row.usable, 0.5 * row.campaigns) << where;
    EXPECT_LT(row.score, 3) << where;
  }
}

}  // namespace
}  // namespace tribotrack::bench
