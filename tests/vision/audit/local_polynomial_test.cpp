#include "vision/audit/local_polynomial.h"

#include <gtest/gtest.h>

#include <array>

#include "vision/audit/synthetic_track.h"

namespace tribotrack::vision {
namespace {

using test::kSigma;
using test::track_of;
using test::white;

TEST(LocalPolynomial, LeavesNothingOfAPolynomialOfItsDegree) {
  for (const int order : {2, 4, 6}) {
    const LocalPolynomial fit(order);
    std::vector<double> values;
    for (int k = 0; k < 40; ++k) values.push_back(3 - 0.2 * k + std::pow(0.05 * k, order));
    const auto left = fit.residual(values);
    ASSERT_EQ(left.size(), 40 - 2 * fit.half());
    for (const double r : left) EXPECT_NEAR(r, 0, 1e-9);
    EXPECT_NEAR(fit.smoothed(values)[20], values[20], 1e-9);
  }
}

/// Savitzky and Golay's table for a quadratic over nine points: (-21 14 39 54 59 54 39 14 -21) / 231.
TEST(LocalPolynomial, WeightsAreTheirTable) {
  const LocalPolynomial fit(2);
  ASSERT_EQ(fit.half(), 4U);
  std::vector<double> one(9, 0);
  const double table[] = {-21, 14, 39, 54, 59, 54, 39, 14, -21};
  for (std::size_t k = 0; k < 9; ++k) {
    one.assign(9, 0);
    one[k] = 231;
    EXPECT_NEAR(fit.residual(one)[0], (k == 4 ? 231 : 0) - table[k], 1e-9);
  }
  EXPECT_NEAR(fit.smoothed_variance(), 59.0 / 231, 1e-12);
}

TEST(LocalPolynomial, TransposedIsTheAdjoint) {
  const LocalPolynomial fit(4);
  std::mt19937 random(1);
  std::vector<double> a(50), b(50 - 2 * fit.half());
  for (double& v : a) v = white(random, 1);
  for (double& v : b) v = white(random, 1);
  const auto left = fit.residual(a), back = fit.transposed(b, 50);
  double forth = 0, and_back = 0;
  for (std::size_t k = 0; k < b.size(); ++k) forth += left[k] * b[k];
  for (std::size_t k = 0; k < 50; ++k) and_back += a[k] * back[k];
  EXPECT_NEAR(forth, and_back, 1e-10);
}

/// Each error is rho times the last of its coordinate and white noise.
std::function<double(int, std::mt19937&)> autoregression(double rho) {
  return [rho, last = std::array<double, 2>{}](int, std::mt19937& random) mutable {
    last = {last[1], rho * last[0] + white(random)};
    return last[1];
  };
}

/// So that the bisection is right: on both sides of white noise a higher correlation leaves a higher one.
TEST(LocalPolynomial, ResidualsOfAnAutoregressionAreAlikeAsItIs) {
  for (const int order : {2, 4, 6}) {
    const LocalPolynomial fit(order);
    double last = -1;
    for (double rho = -0.99; rho < 0.99; rho += 0.01) {
      EXPECT_GT(fit.lag1(rho), last) << order << " " << rho;
      last = fit.lag1(rho);
    }
  }
}

TEST(Lag1, WhiteNoiseHasNoneAndAlternatingErrorsTheirOwn) {
  const auto rest = [](int) { return 0.0; };
  const auto lag1 = [&](const std::function<double(int, std::mt19937&)>& error) {
    return lag1_correlation(stretches(track_of(4000, 1, rest, error)), kAlongX, LocalPolynomial(2))->value;
  };
  EXPECT_NEAR(lag1([](int, std::mt19937& r) { return white(r); }), 0, 0.05);
  EXPECT_NEAR(lag1([](int k, std::mt19937& r) { return (k % 2 == 0 ? 0.1 : -0.1) + white(r); }), -0.98, 0.02);
  for (const double rho : {-0.8, -0.4, 0.5}) EXPECT_NEAR(lag1(autoregression(rho)), rho, 0.06);
  EXPECT_FALSE(
      lag1_correlation(stretches(track_of(50, 1, rest, [](int, std::mt19937& r) { return white(r); })),
                       kAlongX, LocalPolynomial(2)));
}

}  // namespace
}  // namespace tribotrack::vision
