// Taylor series of the sliding motion away from u = 0, in the phase s.
#pragma once

#include <cmath>

#include "model/equation/scaled_problem.h"

namespace tribotrack::model::internal {

inline constexpr int kMaxOrder = 32;
/// exp(-z) to z = kDecayPerStep is within 4e-11 of its Taylor polynomial of order 20.
inline constexpr double kDecayPerStep = 2.5;

/// sum_k c[k] t^k
template <class T, class Time>
auto evaluate(const T* c, int order, const Time& t) {
  decltype(c[0] * t) sum = c[order];
  for (int k = order - 1; k >= 0; --k) sum = sum * t + c[k];
  return sum;
}
/// integral from 0 to t of the same
template <class T, class Time>
auto evaluate_integral(const T* c, int order, const Time& t) {
  decltype(c[0] * t) sum = c[order] * (1.0 / (order + 1));
  for (int k = order - 1; k >= 0; --k) sum = sum * t + c[k] * (1.0 / (k + 1));
  return sum * t;
}

/// Order for a tolerance: minimises work per unit of phase (Jorba & Zou 2005, section 3.1).
inline int taylor_order(double tolerance) {
  const int order = static_cast<int>(std::ceil(-0.5 * std::log(tolerance))) + 1;
  return order < 6 ? 6 : order > kMaxOrder - 2 ? kMaxOrder - 2 : order;
}

/// U(s + t) = sum_k (x[k], y[k]) t^k.
template <class T>
struct SlipSeries {
  int order = 0;
  T x[kMaxOrder], y[kMaxOrder];
  double square[kMaxOrder];  ///< |U|^2, coefficients 0 .. order - 1 (from rest: |U/t|^2)
  bool frictionless = false;
  double kappa_value = 0;
  double direction[kMaxOrder];  ///< sizes of the coefficients of U/|U|, 0 .. order - 1

  /// |u|^2 = q, q^(-1/2) = p from q p' = -p q'/2, then (k+1) u_{k+1} = d_k - kappa (p u)_k.
  void expand(const ScaledDrive<T>& drive, const T& kappa, double s, const Pair<T>& u, int degree);
  /// The longest step whose truncation error is `tolerance` relative to the series' first coefficient, number
  /// `first` (Jorba & Zou 2005, eq. 3-8).
  double step(double tolerance, int first = 0) const;
  /// The first t in (0, h] where |U|^2 (from rest: |U/t|^2) has fallen to `low`; h if it stays above. The
  /// coefficients do not tell: motion along a line runs through U = 0 without a trace in them.
  double stays_above(double low, double h) const;
};

template <class T>
void SlipSeries<T>::expand(const ScaledDrive<T>& drive, const T& kappa, double s, const Pair<T>& u,
                           int degree) {
  using std::sqrt;
  order = degree;
  kappa_value = value(kappa);
  T q[kMaxOrder], p[kMaxOrder];
  frictionless = derivative_count<T> == 0 && value(kappa) == 0;
  x[0] = u.x;
  y[0] = u.y;
  double c = std::cos(s), k_sin = std::sin(s);  // derivatives of cos and sin at s, divided by k!
  for (int k = 0; k < degree; ++k) {
    T fx{}, fy{};
    if (!frictionless) {
      T sum_q{};
      for (int j = 0; 2 * j < k; ++j) sum_q += x[j] * x[k - j] + y[j] * y[k - j];
      sum_q *= 2.0;
      if (k % 2 == 0) sum_q += x[k / 2] * x[k / 2] + y[k / 2] * y[k / 2];
      q[k] = sum_q;
      square[k] = value(sum_q);
      if (k == 0) {
        p[0] = 1.0 / sqrt(q[0]);
      } else {
        T sum{};
        for (int j = 1; j <= k; ++j) sum += (k - 0.5 * j) * (q[j] * p[k - j]);
        p[k] = sum / (q[0] * static_cast<double>(-k));
      }
      for (int j = 0; j <= k; ++j) {
        fx += p[j] * x[k - j];
        fy += p[j] * y[k - j];
      }
      direction[k] = std::fmax(std::fabs(value(fx)), std::fabs(value(fy)));
    }
    T dx = drive.p.x * c + drive.q.x * k_sin, dy = drive.p.y * c + drive.q.y * k_sin;
    if (k == 0) {
      dx += drive.constant.x;
      dy += drive.constant.y;
    }
    x[k + 1] = (dx - kappa * fx) * (1.0 / (k + 1));
    y[k + 1] = (dy - kappa * fy) * (1.0 / (k + 1));
    const double next_c = -k_sin / (k + 1);
    k_sin = c / (k + 1);
    c = next_c;
  }
}

template <class T>
double SlipSeries<T>::step(double tolerance, int first) const {
  const double scale = std::hypot(value(x[first]), value(y[first]));
  double h = HUGE_VAL;
  for (int k = order - 1; k <= order; ++k) {
    const double size = std::fmax(std::fabs(value(x[k])), std::fabs(value(y[k])));
    if (size > 0) h = std::fmin(h, std::pow(tolerance * scale / size, 1.0 / (k - first)));
    // dU/dkappa feels the direction however weak the friction is.
    if (derivative_count < T >> 0 && direction[k - 1] > 0)
      h = std::fmin(h, std::pow(1e2 * tolerance / direction[k - 1], 1.0 / (k - 1)));
  }
  // Behind a zero of U at the distance sqrt(q_0/q_2) the sums for the direction cancel to rounding errors
  // that grow as (h/distance)^k; along a line, where the direction is constant, nothing else would show it.
  if (!frictionless && square[2] != 0) h = std::fmin(h, std::sqrt(square[0] / std::fabs(square[2])));
  // Where a motion has settled its coefficients do not show how fast neighbours settle; its derivatives need
  // that.
  if (derivative_count < T >> 0 && first == 0 && kappa_value > 0)
    h = std::fmin(h, kDecayPerStep * scale / kappa_value);
  return h;
}

template <class T>
double SlipSeries<T>::stays_above(double low, double h) const {
  if (frictionless) return h;
  double change = 0;
  for (int k = order - 1; k >= 1; --k) change = (change + std::fabs(square[k])) * h;
  if (square[0] - change > low) return h;
  const auto square_at = [&](double t) { return evaluate(square, order - 1, t); };
  const auto slope_at = [&](double t) {
    double slope = 0;
    for (int k = order - 1; k >= 1; --k) slope = slope * t + k * square[k];
    return slope;
  };
  constexpr int kSamples = 24;
  double before = 0, slope_before = slope_at(0);
  for (int i = 1; i <= kSamples; ++i) {
    const double sample = h * i / kSamples, slope = slope_at(sample);
    double high = sample;
    if (square_at(high) > low && slope_before < 0 && slope > 0) {
      // A dip in between: to its bottom, however narrow it is.
      double falls = before, rises = sample;
      for (int j = 0; j < 50; ++j) {
        high = 0.5 * (falls + rises);
        (slope_at(high) < 0 ? falls : rises) = high;
      }
    }
    if (square_at(high) <= low) {
      for (int j = 0; j < 30; ++j) {
        const double middle = 0.5 * (before + high);
        (square_at(middle) > low ? before : high) = middle;
      }
      return before > 0 ? before : high;
    }
    before = sample;
    slope_before = slope;
  }
  return h;
}

}  // namespace tribotrack::model::internal
