#include "fit/tools/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace tribotrack::fit::internal {
namespace {

// Thousands of runs of exact data: nothing of the distribution lies below such a chi^2.
TEST(Statistics, AnyChi2HasASurvivalThatFalls) {
  for (const double dof : {1.0, 3.0, 140.0, 149.0, 150.0, 151.0, 170.0, 3600.0, 5997.0, 1e5, 2e6}) {
    double before = 1;
    for (double x = 1e-300; x < 1e9; x *= 1.7) {
      const double now = chi2_survival(x, dof);
      EXPECT_LE(now, before + 1e-15) << x << " " << dof;
      EXPECT_GE(now, 0) << x << " " << dof;
      before = now;
    }
    EXPECT_GT(chi2_survival(1e-12, dof), 0.999) << dof;
    EXPECT_LT(before, 1e-15) << dof;
  }
}

TEST(Statistics, EdgesOfTheDistributions) {
  EXPECT_NEAR(chi2_survival(37.65248413348278, 25), 0.05, 1e-12);
  EXPECT_NEAR(chi2_quantile(0.95, 25), 37.65248413348278, 1e-9);
  EXPECT_EQ(chi2_survival(10, 0), 1);
  EXPECT_EQ(chi2_survival(0, 3), 1);
  EXPECT_EQ(chi2_survival(HUGE_VAL, 3), 0);
  EXPECT_NEAR(two_sided_quantile(0.95, 25), 2.059538552753294, 1e-12);
  EXPECT_EQ(two_sided_quantile(0.95, 2e4), two_sided_quantile(0.95, HUGE_VAL));
}

TEST(Statistics, AutocorrelationTimeOfAFirstOrderProcess) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1);
  for (const double rho : {0.0, 0.5, 0.8}) {
    std::vector<double> series(20000);
    double state = 0;
    for (double& value : series) value = state = rho * state + noise(random);
    const double exact = (1 + rho) / (1 - rho);
    EXPECT_NEAR(autocorrelation_time(series), exact, 0.15 * exact) << rho;
  }
}

}  // namespace
}  // namespace tribotrack::fit::internal
