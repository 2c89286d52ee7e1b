// 95 % intervals hold the truth at their rate.
#include "apps/bench/fit/coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <thread>

#include "fit/slow_friction.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

/// P(X <= k) for X binomial with n tries.
double binomial_cdf(int k, int n, double p) {
  double sum = 0;
  for (int i = 0; i <= k; ++i)
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) + i * std::log(p) +
                    (n - i) * std::log1p(-p));
  return sum;
}

void print(const std::vector<CoverageRow>& rows) {
  for (const CoverageRow& row : rows)
    std::printf("%-22s %-14s %4d counted (%d weak), %d unusable: %.1f %%, by profile %.1f %%\n",
                row.kind.c_str(), row.parameter.c_str(), row.campaigns, row.weak, row.unusable,
                100 * row.share(), 100 * row.profile_share());
}

// Exact bounds: a fit whose intervals hold in 95 % of all cases fails here once in 2000 runs (5 parameters,
// both sides), and always in the same ones: the seed is fixed.
TEST(Coverage, OfSixtyCampaignsIsWithinTheBinomialsBounds) {
  CoverageOptions options;
  options.campaigns = 60;
  options.profiles = false;
  options.seed = 4;
  SCOPED_TRACE(options.seed);
  const auto rows = coverage(options);
  print(rows);
  ASSERT_EQ(rows[0].kind, "all");
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_GE(rows[i].campaigns, i < 3 ? 50 : 24);
    EXPECT_GT(binomial_cdf(rows[i].covered, rows[i].campaigns, 0.95), 5e-5) << rows[i].parameter;
  }
}

TEST(Coverage, ItsDataAreThoseOfAnIndependentIntegrator) {
  const CoverageCampaign campaign = coverage_campaign(9, 3);
  ASSERT_FALSE(campaign.slipping);
  double chi2 = 0;
  for (const SummaryRun& run : campaign.problem.summary_runs) {
    model::Scenario truth = run.scenario;
    truth.friction.nominal = campaign.truth[0];
    truth.friction.reduced = campaign.truth[1];
    truth.friction.lag = campaign.truth[2];
    const Eigen::Vector2d exact = test::SlowFriction(truth).displacement(2000);
    chi2 += (run.measured.vector - exact).squaredNorm() / run.measured.covariance(0, 0);
  }
  EXPECT_GT(chi2, 8);  // 28 degrees of freedom: 1e-4 on either side
  EXPECT_LT(chi2, 64);
}

TEST(CoverageCampaign, DISABLED_OfAThousandCampaignsIsBetween93And97Percent) {
  CoverageOptions options;
  options.threads = static_cast<int>(std::thread::hardware_concurrency());
  SCOPED_TRACE(options.seed);
  const auto rows = coverage(options);
  std::printf("seed %llu\n", static_cast<unsigned long long>(options.seed));
  print(rows);
  for (const CoverageRow& row : rows) {
    if (row.kind != "all") continue;
    EXPECT_GE(row.share(), 0.93) << row.parameter;
    EXPECT_LE(row.share(), 0.97) << row.parameter;
    EXPECT_GE(row.profile_share(), 0.93) << row.parameter;
    EXPECT_LE(row.profile_share(), 0.97) << row.parameter;
    EXPECT_LT(row.unusable, 0.1 * options.campaigns) << row.parameter;
  }
}

}  // namespace
}  // namespace tribotrack::bench
