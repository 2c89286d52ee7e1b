#include "fit/uncertainty/intervals.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tribotrack::fit::internal {

Interval interval95(const Transform& transform, FitParameter parameter, double value, double sd, double t) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!std::isfinite(sd)) return {transform.positive() ? 0 : -kInfinity, kInfinity};
  const bool on_logarithm = transform.positive() && value > 0 && sd < 0.3 * value;
  if (on_logarithm) return {value * std::exp(-t * sd / value), value * std::exp(t * sd / value)};
  const double low = value - t * sd;
  const bool cut = parameter == FitParameter::mu1 || parameter == FitParameter::mu2;
  return {cut ? std::max(0.0, low) : low, value + t * sd};
}

}  // namespace tribotrack::fit::internal
