#include "fit/tools/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tribotrack::fit::internal {
namespace {

TEST(Statistics, ChiSquareMatchesItsTable) {
  EXPECT_NEAR(chi2_survival(3.841458820694124, 1), 0.05, 1e-12);
  EXPECT_NEAR(chi2_survival(5.991464547107979, 2), 0.05, 1e-12);
  EXPECT_NEAR(chi2_survival(37.65248413348278, 25), 0.05, 1e-12);
  for (const double x : {0.1, 1.0, 5.0, 50.0}) EXPECT_NEAR(chi2_survival(x, 2), std::exp(-x / 2), 1e-14);
  for (const double x : {0.1, 1.0, 5.0, 20.0})
    EXPECT_NEAR(chi2_survival(x, 1), std::erfc(std::sqrt(x / 2)), 1e-13);
  EXPECT_EQ(chi2_survival(10, 0), 1);
}

TEST(Statistics, StudentMatchesItsTable) {
  EXPECT_NEAR(two_sided_quantile(0.95, 1), 12.706204736432095, 1e-6);
  EXPECT_NEAR(two_sided_quantile(0.95, 2), 4.302652729911275, 1e-8);
  EXPECT_NEAR(two_sided_quantile(0.95, 25), 2.059538552753294, 1e-9);
  EXPECT_NEAR(two_sided_quantile(0.95, std::numeric_limits<double>::infinity()), 1.959963984540054, 1e-12);
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
