#include "model/spin/disc_friction.h"

#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/ellint_2.hpp>
#include <cmath>
#include <numbers>
#include <utility>

namespace tribotrack::model::internal {
namespace {

constexpr double kPi = std::numbers::pi;

/// Below it the series is summed; above it the closed forms lose at most 1/m^2 = 100 units of the last place
/// to cancellation. Anything from 0.05 to 0.5 gives twelve digits.
constexpr double kSeriesUpTo = 0.1;

/// F(a, b; c; m) by its series.
double hypergeometric(double a, double b, double c, double m) {
  double term = 1, sum = 1;
  for (int n = 0; std::abs(term) > 1e-18 * std::abs(sum) && n < 60; ++n) {
    term *= (a + n) * (b + n) / ((c + n) * (n + 1)) * m;
    sum += term;
  }
  return sum;
}

WithSlope series(double factor, double a, double b, double c, double m) {
  return {factor * hypergeometric(a, b, c, m), factor * a * b / c * hypergeometric(a + 1, b + 1, c + 1, m)};
}

/// The complete elliptic integrals E(m) and (1 - m) K(m).
std::pair<double, double> elliptic(double m) {
  const double k = std::sqrt(m);
  return {boost::math::ellint_2(k), m < 1 ? (1 - m) * boost::math::ellint_1(k) : 0};
}

}  // namespace

WithSlope face_drag(double m) {
  if (m < kSeriesUpTo) return series(1, 0.5, -0.5, 2, m);
  const auto [e, k_rest] = elliptic(m);
  return {4 / (3 * kPi * m) * ((1 + m) * e - k_rest), -2 / (3 * kPi * m * m) * ((2 - m) * e - 2 * k_rest)};
}

WithSlope slow_spin_brake(double m) {
  if (m < kSeriesUpTo) return series(0.25, 0.5, 0.5, 3, m);
  const auto [e, k_rest] = elliptic(m);
  const double brake = 4 / (9 * kPi * m * m) * ((4 * m - 2) * e + (2 - 3 * m) * k_rest);
  const double by_ratio = 4 / (3 * kPi * m * m) * ((2 - m) * e - 2 * k_rest);  // d(torque)/d(w/u)
  return {brake, (by_ratio - brake) / (2 * m)};
}

WithSlope fast_spin_brake(double m) {
  if (m < kSeriesUpTo) return series(2.0 / 3, -1.5, 0.5, 1, m);
  const auto [e, k_rest] = elliptic(m);
  return {4 / (9 * kPi) * ((4 - 2 * m) * e - k_rest), -2 / (3 * kPi * m) * ((2 * m - 1) * e + k_rest)};
}

}  // namespace tribotrack::model::internal
