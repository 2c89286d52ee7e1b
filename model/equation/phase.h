// Phases modulo 2 pi without loss, however many cycles they count.
#pragma once

#include <cmath>
#include <numbers>

namespace tribotrack::model::internal {

inline constexpr double kTwoPi = 2 * std::numbers::pi;
/// 2 pi = kTwoPi + kTwoPiRest to twice double precision.
inline constexpr double kTwoPiRest = 2.4492935982947064e-16;

/// cycles * 2 pi + rest, rest in [0, 2 pi).
struct Phase {
  double cycles = 0;
  double rest = 0;
};

/// Reduces phase + correction (|correction| << |phase|: the part of the sum a double could not hold).
inline Phase reduce(double phase, double correction = 0) {
  Phase p;
  p.cycles = std::floor(phase / kTwoPi);
  p.rest = std::fma(-p.cycles, kTwoPi, phase) - p.cycles * kTwoPiRest + correction;
  if (p.rest < 0) {
    p.cycles -= 1;
    p.rest += kTwoPi;
  }
  if (p.rest >= kTwoPi) {
    p.cycles += 1;
    p.rest = std::fmax(0.0, p.rest - kTwoPi);
  }
  return p;
}

/// a * b reduced, with the rounding error of the product kept.
inline Phase reduce_product(double a, double b) {
  const double product = a * b;
  return reduce(product, std::fma(a, b, -product));
}

}  // namespace tribotrack::model::internal
