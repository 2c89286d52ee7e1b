// Forward-mode dual numbers of fixed size: a value and its derivatives with respect to N parameters.
#pragma once

#include <array>
#include <cmath>

namespace tribotrack::model::internal {

/// v + sum_j d[j] e_j with e_i e_j = 0.
template <int N>
struct Jet {
  double v = 0;
  std::array<double, N> d{};

  Jet() = default;
  Jet(double value) : v(value) {}  // NOLINT: a number is a Jet without derivatives

  Jet& operator+=(const Jet& o) {
    v += o.v;
    for (int j = 0; j < N; ++j) d[j] += o.d[j];
    return *this;
  }
  Jet& operator-=(const Jet& o) {
    v -= o.v;
    for (int j = 0; j < N; ++j) d[j] -= o.d[j];
    return *this;
  }
  Jet& operator*=(double k) {
    v *= k;
    for (int j = 0; j < N; ++j) d[j] *= k;
    return *this;
  }
  Jet operator-() const { return Jet(*this) *= -1.0; }
  /// += k o, without a copy.
  void add(double k, const Jet& o) {
    v += k * o.v;
    for (int j = 0; j < N; ++j) d[j] += k * o.d[j];
  }

  friend Jet operator+(Jet a, const Jet& b) { return a += b; }
  friend Jet operator-(Jet a, const Jet& b) { return a -= b; }
  friend Jet operator+(Jet a, double b) {
    a.v += b;
    return a;
  }
  friend Jet operator+(double a, const Jet& b) { return b + a; }
  friend Jet operator-(Jet a, double b) {
    a.v -= b;
    return a;
  }
  friend Jet operator-(double a, const Jet& b) { return -b + a; }
  friend Jet operator*(Jet a, double b) { return a *= b; }
  friend Jet operator*(double a, Jet b) { return b *= a; }
  friend Jet operator*(const Jet& a, const Jet& b) {
    Jet c(a.v * b.v);
    for (int j = 0; j < N; ++j) c.d[j] = a.v * b.d[j] + a.d[j] * b.v;
    return c;
  }
  friend Jet operator/(Jet a, double b) {
    a.v /= b;
    for (int j = 0; j < N; ++j) a.d[j] /= b;
    return a;
  }
  friend Jet operator/(const Jet& a, const Jet& b) {
    Jet c(a.v / b.v);
    const double inverse = 1 / b.v;
    for (int j = 0; j < N; ++j) c.d[j] = (a.d[j] - c.v * b.d[j]) * inverse;
    return c;
  }
};

/// f(a) given f and f' at a.v.
template <int N>
Jet<N> chain(const Jet<N>& a, double f, double slope) {
  Jet<N> c(f);
  for (int j = 0; j < N; ++j) c.d[j] = slope * a.d[j];
  return c;
}
template <int N>
Jet<N> sqrt(const Jet<N>& a) {
  const double root = std::sqrt(a.v);
  return chain(a, root, 0.5 / root);
}
template <int N>
Jet<N> sin(const Jet<N>& a) {
  return chain(a, std::sin(a.v), std::cos(a.v));
}
template <int N>
Jet<N> cos(const Jet<N>& a) {
  return chain(a, std::cos(a.v), -std::sin(a.v));
}
template <int N>
Jet<N> exp(const Jet<N>& a) {
  const double e = std::exp(a.v);
  return chain(a, e, e);
}

inline double value(double a) {
  return a;
}
template <int N>
double value(const Jet<N>& a) {
  return a.v;
}

/// Number of derivatives a scalar type carries.
template <class T>
inline constexpr int derivative_count = 0;
template <int N>
inline constexpr int derivative_count<Jet<N>> = N;

/// The same number without its value: what a quantity changes by, to first order.
inline double change(double) {
  return 0;
}
template <int N>
Jet<N> change(Jet<N> a) {
  a.v = 0;
  return a;
}
/// The same number with a new value and the old derivatives.
inline double with_value(double, double v) {
  return v;
}
template <int N>
Jet<N> with_value(Jet<N> a, double v) {
  a.v = v;
  return a;
}

/// sum += k a
inline void add_multiple(double& sum, double k, double a) {
  sum += k * a;
}
template <int N>
void add_multiple(Jet<N>& sum, double k, const Jet<N>& a) {
  sum.add(k, a);
}

inline bool same(double a, double b) {
  return a == b;
}
template <int N>
bool same(const Jet<N>& a, const Jet<N>& b) {
  return a.v == b.v && a.d == b.d;
}

/// A plane vector of scalars T.
template <class T>
struct Pair {
  T x{}, y{};
  friend Pair operator+(const Pair& a, const Pair& b) { return {a.x + b.x, a.y + b.y}; }
  friend Pair operator-(const Pair& a, const Pair& b) { return {a.x - b.x, a.y - b.y}; }
  friend Pair operator*(const T& k, const Pair& a) { return {k * a.x, k * a.y}; }
};
template <class T>
void add_multiple(Pair<T>& sum, double k, const Pair<T>& a) {
  add_multiple(sum.x, k, a.x);
  add_multiple(sum.y, k, a.y);
}
template <class T>
T dot(const Pair<T>& a, const Pair<T>& b) {
  return a.x * b.x + a.y * b.y;
}
template <class T>
Pair<double> values(const Pair<T>& a) {
  return {value(a.x), value(a.y)};
}
template <class T>
double length(const Pair<T>& a) {
  return std::hypot(value(a.x), value(a.y));
}

}  // namespace tribotrack::model::internal
