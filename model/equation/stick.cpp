#include "model/equation/stick.h"

#include <algorithm>

namespace tribotrack::model::internal {

double Excess::operator()(double s) const {
  return c0_ + c1_ * std::cos(s) + s1_ * std::sin(s) + c2_ * std::cos(2 * s) + s2_ * std::sin(2 * s);
}

double Excess::slope(double s) const {
  return s1_ * std::cos(s) - c1_ * std::sin(s) + 2 * (s2_ * std::cos(2 * s) - c2_ * std::sin(2 * s));
}

bool Excess::holds(double s) const {
  const double excess = (*this)(s);
  if (excess <= -floor_) return true;
  // On the threshold: held unless the drive is growing through it.
  return excess <= floor_ && slope(s) <= 1e-7 * curvature_;
}

namespace {

/// Root of a function growing through zero in [low, high], by Newton kept inside by bisection.
double root(const Excess& f, double low, double high) {
  double s = 0.5 * (low + high);
  for (int i = 0; i < 100; ++i) {
    const double y = f(s);
    (y < 0 ? low : high) = s;
    double next = s - y / f.slope(s);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::fabs(next - s) <= 2e-16 * std::max(1.0, std::fabs(s)) || high - low < 1e-16) return next;
    s = next;
  }
  return s;
}

}  // namespace

double Excess::release(double from, double to) const {
  // Walks along certified intervals: over a length h the excess stays below its tangent + curvature h^2/2.
  if (curvature_ <= floor_) return to;
  double s = from;
  while (s < to) {
    const double gap = floor_ - (*this)(s), rate = slope(s);
    const double safe = gap > 0 ? (std::sqrt(rate * rate + 2 * curvature_ * gap) - rate) / curvature_ : 0.0;
    const double h = std::max(safe, 1e-6);
    const double next = std::min(to, s + h);
    if ((*this)(next) > floor_) return (*this)(s) < 0 ? root(*this, s, next) : s;
    s = next;
  }
  return to;
}

}  // namespace tribotrack::model::internal
