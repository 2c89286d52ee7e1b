// Elementary functions in quadruple precision, each by its definition.
#pragma once

#include <cmath>

namespace tribotrack::model::reference {

__extension__ typedef __float128 quad;

inline quad absolute(quad x) {
  return x < 0 ? -x : x;
}
inline quad square_root(quad x) {
  if (!(x > 0)) return 0;
  quad r = std::sqrt(static_cast<double>(x));
  if (r == 0) r = static_cast<quad>(1e-160);
  for (int i = 0; i < 4; ++i) r = (r + x / r) / 2;
  return r;
}
/// Machin's formula.
inline quad pi() {
  const auto arctan_inverse = [](int n) {
    quad sum = 0, power = quad(1) / n;
    for (int k = 0; k < 60; ++k, power /= n * n) sum += (k % 2 == 0 ? power : -power) / (2 * k + 1);
    return sum;
  };
  static const quad value = 4 * (4 * arctan_inverse(5) - arctan_inverse(239));
  return value;
}
inline quad floor_of(quad x) {
  quad n = std::floor(static_cast<double>(x));
  while (n > x) n -= 1;
  while (n + 1 <= x) n += 1;
  return n;
}
inline void sine_cosine(quad x, quad& s, quad& c) {
  x -= 2 * pi() * floor_of(x / (2 * pi()) + quad(0.5));
  x /= 64;
  quad sine = 0, versine = 0, term = x;  // sin and 1 - cos of the small angle
  for (int k = 1; k < 16; ++k) {
    sine += term;
    term *= x / (2 * k);
    versine += term;
    term *= -x / (2 * k + 1);
  }
  for (int i = 0; i < 6; ++i) {  // doubling: 1 - cos 2x = 2 sin^2 x
    const quad doubled = 2 * sine * (1 - versine);
    versine = 2 * sine * sine;
    sine = doubled;
  }
  s = sine;
  c = 1 - versine;
}

}  // namespace tribotrack::model::reference
