// The friction of a spinning disc by brute force: a sum over all of its face, a fixed small step.
// Knows nothing of elliptic integrals.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace tribotrack::test {

/// Force and torque of a disc at speed u and edge speed w, per mu m g and per mu m g R.
struct FaceForce {
  double force = 0, torque = 0;
};

/// By a sum over directions seen from the face's resting point (on the disc or beside it), about which it
/// turns: friction along a ray has one direction, and only the chord's length counts. Spectral but
/// for u near w. No spin, or w >= 0.05 u.
inline FaceForce force_by_directions(double u, double w) {
  if (w == 0) return {1, 0};
  constexpr int kDirections = 96;
  const double d = u / w, pi = std::numbers::pi;
  double force = 0, dissipated = 0;  // <cos>, <|v|>/w
  for (int k = 0; k < kDirections; ++k) {
    if (d < 1) {
      const double angle = 2 * pi * (k + 0.5) / kDirections, share = 2.0 / kDirections;
      const double root = std::sqrt(1 - std::pow(d * std::sin(angle), 2)), chord = d * std::cos(angle) + root;
      force += share * std::cos(angle) * chord * chord / 2;
      dissipated += share * chord * chord * chord / 3;
    } else {
      const double psi = pi * (k + 0.5) / kDirections - pi / 2, share = 1.0 / kDirections;
      const double half = std::cos(psi), cosine = std::sqrt(1 - std::pow(std::sin(psi) / d, 2));
      force += share * 2 * cosine * half * half;
      dissipated += share * 2 * half * half * (4 * d * d * cosine * cosine - d * d + 1) / (3 * d * cosine);
    }
  }
  return {force, dissipated - d * force};
}

/// A slide from speed 1 and edge speed s0 with mu g = 1, every motion of that ratio but for its units: after
/// the time t v0/(mu g) the way is x v0^2/(mu g) and the disc has turned by rim v0^2/(mu g R).
class UnitSlide {
 public:
  explicit UnitSlide(double s0, double inertia = 0.5) : inertia_(inertia) {
    State s{0, 1, s0, 0};
    way_.push_back(s);
    while (s.u > 1e-3 || s.w > 1e-3) {
      const State a = slope(s), b = slope(moved(s, a, kStep / 2)), c = slope(moved(s, b, kStep / 2)),
                  d = slope(moved(s, c, kStep));
      const State mean{(a.x + 2 * b.x + 2 * c.x + d.x) / 6, (a.u + 2 * b.u + 2 * c.u + d.u) / 6,
                       (a.w + 2 * b.w + 2 * c.w + d.w) / 6, (a.rim + 2 * b.rim + 2 * c.rim + d.rim) / 6};
      s = moved(s, mean, kStep);
      if (!(s.u > 0) || !(s.w >= 0)) break;
      way_.push_back(s);
    }
  }

  double stop_time() const { return kStep * static_cast<double>(way_.size() - 1) + left(); }
  double x(double t) const { return sampled(t, &State::x, &State::u); }
  double rim(double t) const { return sampled(t, &State::rim, &State::w); }

 private:
  static constexpr double kStep = 1e-3;
  struct State {
    double x, u, w, rim;
  };
  static State moved(const State& s, const State& by, double h) {
    return {s.x + h * by.x, s.u + h * by.u, s.w + h * by.w, s.rim + h * by.rim};
  }
  State slope(const State& s) const {
    const FaceForce by = force_by_directions(s.u, s.w);
    return {s.u, -by.force, -by.torque / inertia_, s.w};
  }
  /// From the last state both speeds fall evenly.
  double left() const { return way_.back().u / std::max(1e-9, -slope(way_.back()).u); }
  double sampled(double t, double State::*value, double State::*rate) const {
    const double place = std::clamp(t / kStep, 0.0, static_cast<double>(way_.size() - 1));
    const auto k = std::min(static_cast<std::size_t>(place), way_.size() - 2);
    const double h = place - static_cast<double>(k);
    const State &a = way_[k], &b = way_[k + 1];  // cubic between the states
    const double va = a.*value, vb = b.*value, da = kStep * a.*rate, db = kStep * b.*rate;
    double result = va + h * (da + h * (3 * (vb - va) - 2 * da - db + h * (2 * (va - vb) + da + db)));
    const double after = std::clamp(t - kStep * static_cast<double>(way_.size() - 1), 0.0, left());
    return result + (after - after * after / (2 * std::max(left(), 1e-12))) * way_.back().*rate;
  }

  double inertia_;
  std::vector<State> way_;
};

}  // namespace tribotrack::test
