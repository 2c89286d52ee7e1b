#include "vision/synthesis/quadrature.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tribotrack::vision {
namespace {

double mean(const QuadratureRule& rule, const auto& f) {
  double sum = 0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) sum += rule.weights[i] * f(rule.nodes[i]);
  return sum;
}

TEST(GaussLegendre, IsExactUpToItsDegree) {
  for (const int n : {1, 2, 3, 5, 8, 16, 33, 64, 256}) {
    const QuadratureRule rule = gauss_legendre(n);
    for (int degree = 0; degree <= 2 * n - 1; ++degree) {
      // mean of (x + 1/2)^degree over [-1/2, 1/2]
      EXPECT_NEAR(mean(rule, [&](double x) { return std::pow(x + 0.5, degree); }), 1.0 / (degree + 1), 1e-14)
          << n << " points, degree " << degree;
    }
    // The first degree it misses, by C_n (2n)!.
    if (n <= 5) {
      const double error =
          mean(rule, [&](double x) { return std::pow(x, 2 * n); }) - std::pow(0.5, 2 * n) / (2 * n + 1);
      const double c =
          std::pow(std::tgamma(n + 1.0), 4) / ((2 * n + 1) * std::pow(std::tgamma(2 * n + 1.0), 3));
      EXPECT_NEAR(-error / (c * std::tgamma(2 * n + 1.0)), 1, 1e-6);
    }
  }
  EXPECT_THROW(gauss_legendre(0), std::invalid_argument);
}

TEST(GaussPoints, KeepThePromisedError) {
  for (const double blur : {0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.8, 1.5, 10.0}) {
    for (const double tolerance : {1e-3, 1e-5}) {
      const QuadratureRule rule = gauss_legendre(gauss_points_for_edge(blur, tolerance));
      // d/dx [x Phi + s^2 phi] = Phi for the edge Phi(x) of sd s.
      const auto edge = [&](double x) { return 0.5 * std::erfc(x / (std::sqrt(2.0) * blur)); };
      const auto primitive = [&](double x) {
        return x * edge(x) - blur / std::sqrt(2 * M_PI) * std::exp(-0.5 * x * x / (blur * blur));
      };
      for (double shift = -1; shift <= 1; shift += 0.01) {
        const double truth = primitive(shift + 0.5) - primitive(shift - 0.5);
        EXPECT_NEAR(mean(rule, [&](double x) { return edge(x + shift); }), truth, tolerance) << blur;
      }
    }
  }
  for (const double k : {0.1, 1.0, 3.0, 10.0}) {
    const QuadratureRule rule = gauss_legendre(gauss_points_for_wave(k, 1e-6));
    EXPECT_NEAR(mean(rule, [&](double x) { return std::cos(k * x); }), std::sin(k / 2) / (k / 2), 1e-6);
  }
  EXPECT_EQ(gauss_points_for_edge(0.8, 5e-5), 3);
}

}  // namespace
}  // namespace tribotrack::vision
