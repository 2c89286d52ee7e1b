// How long friction holds a part at rest.
#pragma once

#include <cmath>

#include "model/equation/scaled_problem.h"

namespace tribotrack::model::internal {

/// |d(s)|^2 - kappa^2 = c0 + c1 cos s + s1 sin s + c2 cos 2s + s2 sin 2s: the part is held while it is <= 0.
class Excess {
 public:
  template <class T>
  Excess(const ScaledDrive<T>& d, double kappa);

  double operator()(double s) const;
  double slope(double s) const;
  /// Whether it could be anywhere.
  bool may_hold() const { return c0_ <= std::hypot(c1_, s1_) + std::hypot(c2_, s2_); }
  /// Whether friction holds at s and just after. Excesses below rounding do not count.
  bool holds(double s) const;
  /// The first phase in [from, to] at which the part comes loose; `to` if it never does.
  double release(double from, double to) const;

 private:
  double c0_, c1_, s1_, c2_, s2_, curvature_, floor_;
};

template <class T>
Excess::Excess(const ScaledDrive<T>& d, double kappa) {
  const auto [c, p, q] = values(d);
  const double pp = dot(p, p), qq = dot(q, q);
  c0_ = dot(c, c) + 0.5 * (pp + qq) - kappa * kappa;
  c1_ = 2 * dot(c, p);
  s1_ = 2 * dot(c, q);
  c2_ = 0.5 * (pp - qq);
  s2_ = dot(p, q);
  floor_ = 8e-16 * (kappa * kappa + pp + qq + dot(c, c));
  curvature_ = std::hypot(c1_, s1_) + 4 * std::hypot(c2_, s2_);
}

}  // namespace tribotrack::model::internal
