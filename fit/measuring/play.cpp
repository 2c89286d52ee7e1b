#include <algorithm>
#include <cmath>

#include "fit/measurement.h"
#include "fit/tools/angles.h"

namespace tribotrack::fit {

SeenThroughPlay seen_through_play(double amplitude, double half_width) {
  using internal::pi;
  if (!(half_width > 0)) return {};
  const double r = amplitude > 0 ? half_width / amplitude : 1;
  if (r >= 1) return {1, pi / 2};
  const double a = (pi / 2 + std::asin(1 - 2 * r) + 2 * (1 - 2 * r) * std::sqrt(r * (1 - r))) / pi;
  const double b = 4 * r * (1 - r) / pi;
  return {1 - std::hypot(a, b), std::atan2(b, a)};
}

}  // namespace tribotrack::fit
