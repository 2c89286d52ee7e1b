#include "vision/synthesis/quadrature.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace tribotrack::vision {
namespace {

constexpr int kMostPoints = 256;

/// log of C_n = n!^4 / ((2n + 1) (2n)!^3)
double log_error_constant(int n) {
  return 4 * std::lgamma(n + 1.0) - std::log(2 * n + 1.0) - 3 * std::lgamma(2 * n + 1.0);
}

}  // namespace

QuadratureRule gauss_legendre(int points) {
  if (points < 1) throw std::invalid_argument("a quadrature rule needs at least one point");
  QuadratureRule rule;
  rule.nodes.resize(points);
  rule.weights.resize(points);
  for (int i = 0; i < points; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (points + 0.5));
    double slope = 1;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double previous = 1;
      double legendre = x;
      for (int n = 2; n <= points; ++n) {
        const double next = ((2 * n - 1) * x * legendre - (n - 1) * previous) / n;
        previous = legendre;
        legendre = next;
      }
      slope = points * (x * legendre - previous) / (x * x - 1);
      const double step = legendre / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    rule.nodes[i] = x / 2;
    rule.weights[i] = 1 / ((1 - x * x) * slope * slope);
  }
  return rule;
}

int gauss_points_for_edge(double blur, double tolerance) {
  for (int n = 1; n < kMostPoints; ++n) {
    const double log_bound =
        std::log(0.435) + 0.5 * std::lgamma(2.0 * n) + log_error_constant(n) - 2 * n * std::log(blur);
    if (log_bound < std::log(tolerance)) return n;
  }
  return kMostPoints;
}

int gauss_points_for_wave(double wave_number, double tolerance) {
  for (int n = 1; n < kMostPoints; ++n) {
    if (log_error_constant(n) + 2 * n * std::log(std::abs(wave_number)) < std::log(tolerance)) return n;
  }
  return kMostPoints;
}

}  // namespace tribotrack::vision
