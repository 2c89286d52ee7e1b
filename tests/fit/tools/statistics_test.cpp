#include "fit/tools/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace tribotrack::fit::internal {
namespace {

/// Closed forms (Abramowitz and Stegun 26.4.4, 26.4.5): a Poisson sum for even degrees of freedom,
/// half-integer terms and erfc for odd ones.
double chi2_survival_reference(double x, int dof) {
  double sum = 0, term = 0;
  if (dof % 2 == 0) {
    term = std::exp(-x / 2);
    for (int k = 0; k < dof / 2; term *= x / 2 / ++k) sum += term;
    return sum;
  }
  term = std::sqrt(2 * x / std::numbers::pi) * std::exp(-x / 2);
  for (int k = 1; k < dof; k += 2, term *= x / k) sum += term;
  return std::erfc(std::sqrt(x / 2)) + sum;
}

/// P(|T| < t), Abramowitz and Stegun 26.7.3, 26.7.4, finite sums of cos(theta), theta = atan(t / sqrt(dof)).
double student_reference(double t, int dof) {
  const double theta = std::atan(t / std::sqrt(static_cast<double>(dof))), c = std::cos(theta);
  double sum = 0, term = dof % 2 == 1 ? c : 1;
  for (int k = dof % 2 == 1 ? 1 : 0; k <= dof - 2; k += 2) {
    sum += term;
    term *= c * c * (k + 1) / (k + 2);
  }
  return dof % 2 == 1 ? 2 / std::numbers::pi * (theta + std::sin(theta) * sum) : std::sin(theta) * sum;
}

TEST(Statistics, ChiSquareMatchesClosedForms) {
  for (const int dof : {1, 2, 3, 5, 8, 25, 26, 101})
    for (const double x : {0.01, 0.5, 2.0, 10.0, 24.0, 60.0, 150.0}) {
      const double reference = chi2_survival_reference(x, dof);
      EXPECT_NEAR(chi2_survival(x, dof), reference, 1e-12 * reference) << x << " " << dof;
    }
  EXPECT_NEAR(chi2_survival(3.841458820694124, 1), 0.05, 1e-12);
  EXPECT_NEAR(chi2_survival(37.65248413348278, 25), 0.05, 1e-12);
  EXPECT_EQ(chi2_survival(10, 0), 1);
  EXPECT_EQ(chi2_survival(0, 3), 1);
  EXPECT_EQ(chi2_survival(HUGE_VAL, 3), 0);
}

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

TEST(Statistics, ChiSquareQuantileInvertsTheSurvival) {
  for (const double dof : {1.0, 2.5, 25.0, 1e4})
    for (const double p : {0.005, 0.3, 0.995})
      EXPECT_NEAR(chi2_survival(chi2_quantile(p, dof), dof), 1 - p, 1e-12) << dof << " " << p;
}

TEST(Statistics, StudentMatchesClosedForms) {
  for (const int dof : {1, 2, 3, 4, 7, 10, 25, 60, 151})
    for (const double p : {0.5, 0.683, 0.95, 0.99, 0.999})
      EXPECT_NEAR(student_reference(two_sided_quantile(p, dof), dof), p, 1e-12) << dof << " " << p;
  EXPECT_NEAR(two_sided_quantile(0.95, 1), std::tan(0.475 * std::numbers::pi), 1e-12 * 12.7);
  EXPECT_NEAR(two_sided_quantile(0.95, 25), 2.059538552753294, 1e-12);
  EXPECT_NEAR(two_sided_quantile(0.95, HUGE_VAL), 1.9599639845400545, 1e-14);
  EXPECT_EQ(two_sided_quantile(0.95, 2e4), two_sided_quantile(0.95, HUGE_VAL));
}

TEST(Statistics, UpperMedian) {
  EXPECT_EQ(upper_median({3, 1, 2}), 2);
  EXPECT_EQ(upper_median({4, 1, 3, 2}), 3);
  EXPECT_EQ(upper_median({7}), 7);
  EXPECT_NEAR(kSdPerMad, 1 / 0.6744897501960817, 5e-5);
  EXPECT_NEAR(kRayleighMedian, std::sqrt(2 * std::numbers::ln2), 2e-5);
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
