// A part that the drive turns about, near u = 0.
#pragma once

#include <cmath>
#include <optional>

#include "model/equation/scaled_problem.h"

namespace tribotrack::model::internal {

template <class T>
struct Turn {
  double span = 0;
  Pair<T> velocity, moved;
};

/// With d constant, b the angle of U from it and k = kappa/|d|,
///   Q = d.U + kappa |U| grows evenly, by |d|^2 - kappa^2, and C = |U| sin(b) tan(b/2)^(-k) stays:
/// in one step from a U against the drive to the opposite Q, which with C is an equation for tan(b/2). d is
/// that of half-way; its slope adds kappa d'.d/|d| span^2/4 to Q where U goes along a line there and back.
/// nullopt where that is not good to the tolerance.
template <class T>
std::optional<Turn<T>> turn_about(const ScaledDrive<T>& drive, const T& kappa, double s, const Pair<T>& u,
                                  double tolerance) {
  using std::exp;
  using std::log;
  using std::sqrt;
  const Pair<double> plain{value(u.x), value(u.y)};
  const double mu = value(kappa);
  double half = 0;  // of the span
  for (int i = 0; i < 3; ++i) {
    const Pair<double> d = drive.value_at(s + half), size{d.x / length(d), d.y / length(d)};
    const Pair<T> slope = drive.slope(s + half);
    const double bends = value(slope.x) * size.x + value(slope.y) * size.y, norm = length(d),
                 speed = length(plain), across = std::fabs(size.x * plain.y - size.y * plain.x),
                 turns = std::fabs(size.x * value(slope.y) - size.y * value(slope.x));
    if (!(norm > 1.1 * mu && across > 0 && dot(d, plain) < -0.9 * norm * speed)) return std::nullopt;
    half = (-dot(d, plain) - mu * speed + 0.5 * half * half * bends * (norm - mu)) / (norm * norm - mu * mu);
    if (!(std::fabs(bends) * half < 0.1 * norm)) return std::nullopt;
    const double unsure = half + (turns + mu * across / speed) / norm;
    if (!(half > 0 && half * half * unsure < tolerance)) return std::nullopt;
  }
  const Pair<T> d = drive.at(s + half);
  const T norm = sqrt(dot(d, d)), k = kappa / norm;
  const Pair<T> along = T(1.0 / norm) * d, slope = drive.slope(s + half);
  const T speed = sqrt(dot(u, u)), before = dot(along, u);
  T across = along.x * u.y - along.y * u.x;
  const double side = value(across) < 0 ? -1 : 1;
  across *= side;
  const T gained = norm * norm - kappa * kappa, first = norm * before + kappa * speed;
  const T last = first + gained * (2 * half) + kappa * dot(along, slope) * (half * half);
  const T back = across / (speed - before);  // 1/tan(b/2)
  const T wanted = log(2.0 * last / norm) - log(2.0 * speed) - (1.0 + k) * log(back) + log(1.0 + back * back);
  // y = ln tan(b/2) behind the turn.
  T y = (log(1.0 + k) - wanted) / (1.0 - k);
  for (int i = 0; i < 20; ++i) {
    const T square = exp(2.0 * y), left = (1.0 + k) - (1.0 - k) * square;
    if (!(value(left) > 0)) return std::nullopt;
    const T step = (log(left) - (1.0 - k) * y - wanted) / ((1.0 - k) * (1.0 + 2.0 * square / left));
    y += step;
    if (std::fabs(value(step)) < 1e-14) break;
  }
  const T t = exp(y), cosine = (1.0 - t * t) / (1.0 + t * t), sine = 2.0 * t / (1.0 + t * t);
  const T now = last / (norm * cosine + kappa), after = now * cosine;
  const T off = side * now * sine, was_off = side * across;
  const T until = with_value(T(-1.0 * first / gained), half);
  Turn<T> turn;
  turn.span = 2 * half;
  const auto plane = [&](const T& a, const T& b) {
    return Pair<T>{along.x * a - along.y * b, along.y * a + along.x * b};
  };
  turn.velocity = plane(after, off);
  turn.moved = plane(0.5 * (before * until + after * (2 * half - until)), half * (off + was_off));
  return turn;
}

}  // namespace tribotrack::model::internal
