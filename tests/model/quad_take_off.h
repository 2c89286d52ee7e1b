// A smooth take-off in quadruple precision.
#pragma once

#include <array>

#include "model/quad_creep.h"
#include "model/quad_drive.h"
#include "model/quad_math.h"

namespace tribotrack::model::reference {

/// Motion over a stretch of phase.
struct QuadStretch {
  QuadCreep end;
  quad span = 0;
};

/// |d| grows smoothly through kappa at s: u = r n with the formal series of r n' = d - (d.n) n, r' = d.n -
/// kappa.
inline QuadStretch take_off(const QuadDrive& drive, quad kappa, quad s, quad target) {
  constexpr int kTerms = 40;
  quad k, c;
  sine_cosine(s, k, c);
  std::array<quad, kTerms + 1> dx{}, dy{}, nx{}, ny{}, r{}, along{};
  dx[0] = drive.constant_x;
  dy[0] = drive.constant_y;
  quad a = c, b = k;
  for (int j = 0; j <= kTerms; ++j) {
    dx[j] += drive.px * a + drive.qx * b;
    dy[j] += drive.py * a + drive.qy * b;
    const quad next = -b / (j + 1);
    b = a / (j + 1);
    a = next;
  }
  nx[0] = dx[0] / kappa;
  ny[0] = dy[0] / kappa;
  along[0] = kappa;
  for (int j = 1; j < kTerms; ++j) {
    r[j] = j == 1 ? quad(0) : along[j - 1] / j;
    // d_j - lower terms of (d.n) n - (r n')_j, across n0; then |n| = 1 gives the part along n0.
    quad ax = dx[j], ay = dy[j];
    for (int i = 1; i < j; ++i) {
      ax -= along[i] * nx[j - i];
      ay -= along[i] * ny[j - i];
    }
    for (int i = 2; i <= j; ++i) {
      ax -= r[i] * (j - i + 1) * nx[j - i + 1];
      ay -= r[i] * (j - i + 1) * ny[j - i + 1];
    }
    const quad across = (ay * nx[0] - ax * ny[0]) / kappa;
    quad inward = 0;
    for (int i = 1; i < j; ++i) inward -= (nx[i] * nx[j - i] + ny[i] * ny[j - i]) / 2;
    nx[j] = -across * ny[0] + inward * nx[0];
    ny[j] = across * nx[0] + inward * ny[0];
    along[j] = 0;
    for (int i = 0; i <= j; ++i) along[j] += dx[i] * nx[j - i] + dy[i] * ny[j - i];
  }
  const auto sum = [](const auto& f, quad t, int terms) {
    quad total = 0;
    for (int j = terms; j >= 0; --j) total = total * t + f[j];
    return total;
  };
  // The series is asymptotic: go as far as its terms have fallen to rounding.
  quad t = 1;
  constexpr int kLast = kTerms - 2;
  const auto negligible = [&](quad at) {
    quad power = 1;
    for (int j = 0; j < kLast; ++j) power *= at;
    return absolute(nx[kLast] * power) + absolute(ny[kLast] * power) < quad(1e-27);
  };
  while (!negligible(t)) t /= quad(1.25);
  // Not as far as to where the drive falls below friction again: the part may stop there.
  const quad falls = drive.crossing(kappa, s + quad(1e-9), s + t, 0, -1) - s;
  if (falls < t) t = falls / 4;
  if (s + t > target) t = target - s;
  // The position is the integral of the product series.
  std::array<quad, kTerms + 1> vx{}, vy{};
  for (int j = 0; j <= kLast; ++j)
    for (int i = 0; i <= j; ++i) {
      vx[j] += r[i] * nx[j - i];
      vy[j] += r[i] * ny[j - i];
    }
  QuadStretch stretch{{sum(vx, t, kLast), sum(vy, t, kLast), 0, 0}, t};
  for (int j = 0; j <= kLast; ++j) {
    vx[j] /= j + 1;
    vy[j] /= j + 1;
  }
  stretch.end.dx = t * sum(vx, t, kLast);
  stretch.end.dy = t * sum(vy, t, kLast);
  return stretch;
}

}  // namespace tribotrack::model::reference
