// The equation of motion in the platform's own units.
#pragma once

#include <cmath>

#include "model/equation/jet.h"

namespace tribotrack::model::internal {

/// d(s) = constant + p cos s + q sin s, the drive at the local phase s.
template <class T>
struct ScaledDrive {
  Pair<T> constant, p, q;

  Pair<T> at(double s) const {
    const double c = std::cos(s), k = std::sin(s);
    return {constant.x + p.x * c + q.x * k, constant.y + p.y * c + q.y * k};
  }
  /// dd/ds
  Pair<T> slope(double s) const {
    const double c = std::cos(s), k = std::sin(s);
    return {q.x * c - p.x * k, q.y * c - p.y * k};
  }
};
template <class T>
ScaledDrive<double> values(const ScaledDrive<T>& d) {
  return {values(d.constant), values(d.p), values(d.q)};
}

/// Equation (5) divided by w times a velocity unit V (a power of two near (a + mu g)/w, so that every
/// coefficient is of order one). With the local phase s = wt - start phase, U = u/V, X = x w/V:
///   dU/ds = d(s) - kappa n,   dX/ds = U,   kappa = mu g / (w V).
/// All derivatives are taken at fixed s: what depends on the phase of an edge or of the start comes in as a
/// jump.
template <class T>
struct ScaledProblem {
  ScaledDrive<T> drive;
  T kappa_nominal{}, kappa_reduced{};
  double velocity_unit = 1;
};

/// dU/ds at velocity U; at rest the force left over by the friction (zero where it holds).
template <class T>
Pair<T> force(const ScaledDrive<T>& drive, const T& kappa, double s, const Pair<T>& u) {
  using std::sqrt;
  const Pair<T> d = drive.at(s);
  const bool at_rest = value(u.x) == 0 && value(u.y) == 0;
  const Pair<T> along = at_rest ? d : u;
  const double norm = length(along);
  if (at_rest && norm <= value(kappa)) return {};
  if (norm == 0) return d;
  const Pair<T> unit = T(1 / norm) * along;  // scaled first: squares of tiny numbers underflow
  const T k = kappa / sqrt(dot(unit, unit));
  return d - k * unit;
}

}  // namespace tribotrack::model::internal
