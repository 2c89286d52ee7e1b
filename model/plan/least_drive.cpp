#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/plan.h"

namespace tribotrack::model {

double least_drive(const Drive& drive) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const auto d = [&](double s) { return drive.acceleration(s); };
  const Eigen::Vector2d constant = (d(0) + d(kTurn / 2)) / 2, p = d(0) - constant,
                        q = d(kTurn / 4) - constant;
  // Half of the derivative of |d|^2, and its derivative.
  const auto slope = [&](double s) {
    const Eigen::Vector2d value = constant + p * std::cos(s) + q * std::sin(s),
                          rate = q * std::cos(s) - p * std::sin(s);
    return value.dot(rate);
  };
  const auto curvature = [&](double s) {
    const Eigen::Vector2d value = constant + p * std::cos(s) + q * std::sin(s),
                          rate = q * std::cos(s) - p * std::sin(s);
    return rate.squaredNorm() + value.dot(constant - value);
  };
  const auto minimum_between = [&](double low, double high) {
    double s = (low + high) / 2;
    for (int i = 0; i < 100 && high - low > 1e-16; ++i) {
      const double y = slope(s);
      (y < 0 ? low : high) = s;
      double next = s - y / curvature(s);
      if (!(next > low && next < high)) next = (low + high) / 2;
      if (std::fabs(next - s) < 1e-16) break;
      s = next;
    }
    return s;
  };
  constexpr int kSamples = 64;  // at most four roots
  double least = d(0).norm();
  for (int k = 0; k < kSamples; ++k) {
    const double low = kTurn * k / kSamples, high = kTurn * (k + 1) / kSamples;
    least = std::min(least, d(low).norm());
    if (slope(low) <= 0 && slope(high) >= 0) least = std::min(least, d(minimum_between(low, high)).norm());
  }
  return least;
}

}  // namespace tribotrack::model
