// The sliding motion near u = 0, regularised.
#pragma once

#include <cmath>

#include "model/series/slip_series.h"

namespace tribotrack::model::internal {

/// U = e^L (cos b, sin b) and ds = e^L d(sigma) turn the equation into one that is smooth as U -> 0:
///   L' = d.n - kappa,   b' = d.n_perp,   s' = e^L,   X' = e^(2L) n.
/// A stop is approached exponentially in sigma; a pass close by u = 0 is a smooth bend.
template <class T>
struct PolarState {
  T log_speed{}, angle{}, s{}, x{}, y{};

  Pair<T> velocity() const {
    using std::cos;
    using std::exp;
    using std::sin;
    const T r = exp(log_speed);
    return {r * cos(angle), r * sin(angle)};
  }
};

/// Taylor coefficients of a PolarState in sigma. `s` counts from the state's own s.
template <class T>
struct PolarSeries {
  int order = 0;
  double pull = 0;  ///< |d| at the start: the rate in sigma at which the angle settles
  T log_speed[kMaxOrder], angle[kMaxOrder], s[kMaxOrder], x[kMaxOrder], y[kMaxOrder], speed[kMaxOrder];

  void expand(const ScaledDrive<T>& drive, const T& kappa, const PolarState<T>& start, int degree);
  /// Step for an error of `tolerance` in U (absolute in scaled units, at most 1e-7 relative).
  double step(double tolerance) const;
  PolarState<T> at(double sigma) const {
    return {evaluate(log_speed, order, sigma), evaluate(angle, order, sigma), evaluate(s, order, sigma),
            evaluate(x, order, sigma), evaluate(y, order, sigma)};
  }
  /// The sigma in [0, last] where the phase s is `target` (s grows monotonically).
  double solve(double target, double last) const;
};

/// cos and sin of a series a, coefficient k, given coefficients up to k of a and up to k - 1 of c and s.
template <class T>
void extend_cos_sin(const T* a, int k, T* c, T* s) {
  T sum_c{}, sum_s{};
  for (int j = 1; j <= k; ++j) {
    const T weighted = a[j] * static_cast<double>(j);
    sum_c -= weighted * s[k - j];
    sum_s += weighted * c[k - j];
  }
  c[k] = sum_c * (1.0 / k);
  s[k] = sum_s * (1.0 / k);
}

template <class T>
void PolarSeries<T>::expand(const ScaledDrive<T>& drive, const T& kappa, const PolarState<T>& start,
                            int degree) {
  using std::cos;
  using std::exp;
  using std::sin;
  order = degree;
  T cos_b[kMaxOrder], sin_b[kMaxOrder], cos_s[kMaxOrder], sin_s[kMaxOrder], dx[kMaxOrder], dy[kMaxOrder],
      vx[kMaxOrder], vy[kMaxOrder];
  log_speed[0] = start.log_speed;
  angle[0] = start.angle;
  s[0] = start.s;
  x[0] = start.x;
  y[0] = start.y;
  speed[0] = exp(start.log_speed);
  cos_b[0] = cos(start.angle);
  sin_b[0] = sin(start.angle);
  cos_s[0] = cos(start.s);
  sin_s[0] = sin(start.s);
  for (int k = 0; k < degree; ++k) {
    if (k > 0) {
      T sum{};
      for (int j = 1; j <= k; ++j) sum += (log_speed[j] * static_cast<double>(j)) * speed[k - j];
      speed[k] = sum * (1.0 / k);
      extend_cos_sin(angle, k, cos_b, sin_b);
      extend_cos_sin(s, k, cos_s, sin_s);
    }
    dx[k] = drive.p.x * cos_s[k] + drive.q.x * sin_s[k];
    dy[k] = drive.p.y * cos_s[k] + drive.q.y * sin_s[k];
    if (k == 0) {
      dx[0] += drive.constant.x;
      dy[0] += drive.constant.y;
      pull = std::hypot(value(dx[0]), value(dy[0]));
    }
    T along{}, across{}, velocity_x{}, velocity_y{}, move_x{}, move_y{};
    for (int j = 0; j <= k; ++j) {
      along += dx[j] * cos_b[k - j] + dy[j] * sin_b[k - j];
      across += dy[j] * cos_b[k - j] - dx[j] * sin_b[k - j];
      velocity_x += speed[j] * cos_b[k - j];
      velocity_y += speed[j] * sin_b[k - j];
    }
    vx[k] = velocity_x;
    vy[k] = velocity_y;
    for (int j = 0; j <= k; ++j) {
      move_x += speed[j] * vx[k - j];
      move_y += speed[j] * vy[k - j];
    }
    if (k == 0) along -= kappa;
    const double inverse = 1.0 / (k + 1);
    log_speed[k + 1] = along * inverse;
    angle[k + 1] = across * inverse;
    s[k + 1] = speed[k] * inverse;
    x[k + 1] = move_x * inverse;
    y[k + 1] = move_y * inverse;
  }
}

template <class T>
double PolarSeries<T>::step(double tolerance) const {
  const double r = value(speed[0]);
  // An error in L or b is one of r in U, and errors in U never grow (the flow contracts).
  const double weight = std::fmin(1, std::fmax(100 * r, tolerance / 1e-7));
  double h = HUGE_VAL;
  for (int k = order - 1; k <= order; ++k) {
    const double shape = std::fmax(std::fabs(value(log_speed[k])), std::fabs(value(angle[k])));
    const double size = std::fmax(weight * shape, std::fabs(value(s[k])));
    if (size > 0) h = std::fmin(h, std::pow(tolerance / size, 1.0 / k));
  }
  return derivative_count<T> > 0 ? std::fmin(h, kDecayPerStep / pull) : h;
}

template <class T>
double PolarSeries<T>::solve(double target, double last) const {
  double low = 0, high = last, sigma = 0;
  for (int i = 0; i < 100; ++i) {
    double f = value(s[order]), slope = 0;
    for (int k = order - 1; k >= 0; --k) {
      slope = slope * sigma + f;
      f = k == 0 ? f * sigma + (value(s[0]) - target) : f * sigma + value(s[k]);
    }
    if (f == 0) return sigma;
    (f < 0 ? low : high) = sigma;
    double next = sigma - f / slope;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    if (std::fabs(next - sigma) <= 1e-16 * last) return next;
    sigma = next;
  }
  return sigma;
}

}  // namespace tribotrack::model::internal
