// Taylor series of the motion that starts from u = 0 while the drive exceeds the friction.
#pragma once

#include <cmath>

#include "model/series/slip_series.h"

namespace tribotrack::model::internal {

/// Friction at u = 0 is 0/0. With u = t w(t) it is n = w/|w|, regular: w0 = (|d0| - kappa) d0/|d0| and
///   ((k+1) I + kappa/|w0| (I - n0 n0^T)) w_k = d_k - kappa (terms of n_k without w_k).
/// `drive` is the drive counted from the start (so a start at an uncertain phase is a drive with
/// derivatives). Fills series.x/y with the coefficients of U itself.
template <class T>
void expand_from_rest(const ScaledDrive<T>& drive, const T& kappa, int degree, SlipSeries<T>& series) {
  using std::sqrt;
  T wx[kMaxOrder], wy[kMaxOrder], q[kMaxOrder], p[kMaxOrder];
  const Pair<T> d0{drive.constant.x + drive.p.x, drive.constant.y + drive.p.y};
  const T norm = sqrt(dot(d0, d0));
  const Pair<T> n{d0.x / norm, d0.y / norm};
  const T speed = norm - kappa;
  wx[0] = speed * n.x;
  wy[0] = speed * n.y;
  q[0] = speed * speed;
  p[0] = 1.0 / speed;
  series.frictionless = derivative_count<T> == 0 && value(kappa) == 0;
  series.square[0] = value(q[0]);
  series.direction[0] = 1;
  double c = 1, sine = 0;
  for (int k = 1; k < degree; ++k) {
    const double next_c = -sine / k;
    sine = c / k;
    c = next_c;
    T lower_q{};  // q_k without 2 w0.w_k
    for (int j = 1; j < k; ++j) lower_q += wx[j] * wx[k - j] + wy[j] * wy[k - j];
    T lower_p{};  // p_k without the part from w_k
    for (int j = 1; j < k; ++j) lower_p += (k - 0.5 * j) * (q[j] * p[k - j]);
    lower_p += (0.5 * k) * (lower_q * p[0]);
    lower_p = lower_p / (q[0] * static_cast<double>(-k));
    T nx = lower_p * wx[0], ny = lower_p * wy[0];
    for (int j = 1; j < k; ++j) {
      nx += p[k - j] * wx[j];
      ny += p[k - j] * wy[j];
    }
    const T rx = drive.p.x * c + drive.q.x * sine - kappa * nx;
    const T ry = drive.p.y * c + drive.q.y * sine - kappa * ny;
    const T along = (rx * n.x + ry * n.y) / static_cast<double>(k + 1);
    const T across = (ry * n.x - rx * n.y) / (kappa * p[0] + static_cast<double>(k + 1));
    wx[k] = along * n.x - across * n.y;
    wy[k] = along * n.y + across * n.x;
    const T full = 2.0 * (wx[0] * wx[k] + wy[0] * wy[k]);
    q[k] = lower_q + full;
    p[k] = lower_p - (0.5 * (full * p[0])) / q[0];
    series.square[k] = value(q[k]);
    series.direction[k] = std::hypot(value(nx) + (value(wx[k]) - value(n.x) * value(along)) * value(p[0]),
                                     value(ny) + (value(wy[k]) - value(n.y) * value(along)) * value(p[0]));
  }
  series.order = degree;
  series.x[0] = series.y[0] = T(0.0);
  for (int k = 0; k < degree; ++k) {
    series.x[k + 1] = wx[k];
    series.y[k + 1] = wy[k];
  }
}

/// The drive counted from the phase `origin`: d(origin + t).
template <class T>
ScaledDrive<T> shifted(const ScaledDrive<T>& drive, const T& origin) {
  using std::cos;
  using std::sin;
  const T c = cos(origin), s = sin(origin);
  return {drive.constant,
          {drive.p.x * c + drive.q.x * s, drive.p.y * c + drive.q.y * s},
          {drive.q.x * c - drive.p.x * s, drive.q.y * c - drive.p.y * s}};
}

}  // namespace tribotrack::model::internal
