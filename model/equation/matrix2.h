// Two by two: how a motion's neighbours are carried along.
#pragma once

#include <cmath>

#include "model/equation/scaled_problem.h"

namespace tribotrack::model::internal {

struct Matrix2 {
  double xx = 1, xy = 0, yx = 0, yy = 1;

  Pair<double> operator*(const Pair<double>& a) const { return {xx * a.x + xy * a.y, yx * a.x + yy * a.y}; }
  Matrix2 operator*(const Matrix2& a) const {
    return {xx * a.xx + xy * a.yx, xx * a.xy + xy * a.yy, yx * a.xx + yy * a.yx, yx * a.xy + yy * a.yy};
  }
};

inline double spectral_radius(const Matrix2& m) {
  const double half = 0.5 * (m.xx + m.yy), det = m.xx * m.yy - m.xy * m.yx, square = half * half - det;
  return square < 0 ? std::sqrt(det) : std::fabs(half) + std::sqrt(square);
}

/// (1 - m)^-1 b
inline Pair<double> newton_step(const Matrix2& m, const Pair<double>& b) {
  const double a = 1 - m.xx, d = 1 - m.yy, det = a * d - m.xy * m.yx;
  return {(d * b.x + m.xy * b.y) / det, (m.yx * b.x + a * b.y) / det};
}

}  // namespace tribotrack::model::internal
