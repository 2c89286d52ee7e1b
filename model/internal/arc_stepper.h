// Sliding in long arcs where nobody asks what happens inside them.
#pragma once

#include <algorithm>
#include <cmath>

#include "model/internal/arc.h"

namespace tribotrack::model::internal {

/// The kernel's cos and sin are good up to half of this.
inline constexpr double kLongestArc = 2.4;

/// How long the next arc may be at most: at mu1, mu2; later arcs, the first after a switch.
struct ArcSpans {
  double at[2][2];
};
inline constexpr ArcSpans kLongestSpans{{{kLongestArc, kLongestArc}, {kLongestArc, kLongestArc}}};

/// Carries U and X along arcs solved by collocation, and remembers from arc to arc how long the next may be.
template <class T>
class ArcStepper {
 public:
  /// `keep`: the arcs shall be short enough to tell what happens inside them.
  ArcStepper(const ScaledDrive<T>& drive, double tolerance, bool keep);

  /// Friction has just been switched: what follows begins with a transient.
  void begin_segment(bool reduced) {
    reduced_ = reduced;
    first_ = true;
  }
  /// One arc from the phase s towards `target`: true, s and u at its end, and by how much it moved. False,
  /// and nothing changed, where no arc resolves the motion to the tolerance or the speed falls below
  /// `slowest`.
  bool advance(double& s, double target, const T& kappa, double slowest, Pair<T>& u, Pair<T>& moved);
  /// U/|U| at node i of the last arc.
  Pair<T> direction(int i) const;
  const GaussTable& table() const { return table_; }
  const ArcSpans& spans() const { return spans_; }
  void set_spans(const ArcSpans& spans) { spans_ = spans; }
  /// What follows must not depend on what was before.
  void forget() { spans_ = kLongestSpans; }

 private:
  static constexpr int N = derivative_count<T>;
  void solve(double s, const T& kappa, const Pair<T>& u);
  void take(Pair<T>& u, Pair<T>& moved) const;

  const ScaledDrive<T>& drive_;
  double tolerance_;
  const GaussTable& table_;
  ArcSolver solver_;
  double growth_;  ///< of the truncation error when an arc is made kLonger times as long
  ArcInput in_;
  ArcOutput out_;
  ArcColumns columns_;
  ArcSpans spans_ = kLongestSpans;
  bool reduced_ = false, first_ = true;
};

inline constexpr double kShortestArc = 1e-3;
/// kappa h/|U| up to which Picard sweeps pay.
inline constexpr double kSweepable = 5;
inline constexpr double kLonger = 1.25;
/// Share of the last Legendre coefficient that the velocity between the nodes is off by.
inline constexpr double kWithin = 0.02;
/// Looser tolerances are served by 6 nodes, tighter ones by 14.
inline constexpr double kFewNodesTolerance = 1e-6;

template <class T>
ArcStepper<T>::ArcStepper(const ScaledDrive<T>& drive, double tolerance, bool keep)
    : drive_(drive),
      tolerance_(tolerance),
      table_(GaussTable::of_pairs(tolerance >= kFewNodesTolerance && !keep ? 3 : 7)),
      solver_(table_.pairs == 3 ? arc_solvers().few : arc_solvers().many),
      growth_(std::pow(kLonger, keep ? 2 * table_.pairs : 4 * table_.pairs + 1)) {
  in_.keep = keep;
  columns_.count = N <= 4 ? 4 : N <= 8 ? 8 : 16;
  if constexpr (N > 0)
    for (const T* part :
         {&drive.constant.x, &drive.constant.y, &drive.p.x, &drive.p.y, &drive.q.x, &drive.q.y})
      for (int j = 0; j < N; ++j) columns_.drive_varies |= part->d[j] != 0;
}

template <class T>
bool ArcStepper<T>::advance(double& s, double target, const T& kappa, double slowest, Pair<T>& u,
                            Pair<T>& moved) {
  const double left = target - s, speed = std::sqrt(value(u.x) * value(u.x) + value(u.y) * value(u.y));
  const double sweepable = std::fmin(kLongestArc, kSweepable * speed / value(kappa));
  double& longest = spans_.at[reduced_][first_];
  for (int attempt = 0; attempt < 5; ++attempt) {
    if (std::fmin(longest, sweepable) < kShortestArc) break;
    const double arcs = std::ceil(left / std::fmin(longest, sweepable) - 1e-9);
    const double end = arcs > 1 ? s + left / arcs : target;
    in_.span = end - s;
    in_.tolerance = tolerance_ * speed;
    solve(s, kappa, u);
    if (out_.converged && out_.slowest < slowest) return false;
    // At the end the truncation error is the square of that in between.
    const double tail = in_.keep ? kWithin * out_.tail : out_.tail * out_.tail;
    const double error = value(kappa) * in_.span * tail / (tolerance_ * out_.slowest);
    if (out_.converged && error <= 1) {
      if (error * growth_ < 0.3) longest = std::fmax(longest, kLonger * in_.span);
      first_ = false;
      s = end;
      take(u, moved);
      return true;
    }
    longest = in_.span / kLonger;
  }
  longest = std::fmax(longest, 0.1);
  return false;
}

template <class T>
void ArcStepper<T>::solve(double s, const T& kappa, const Pair<T>& u) {
  const double half = 0.5 * in_.span, middle = s + half, rounded = (s - middle) + half;
  const double cosine = std::cos(middle), sine = std::sin(middle);
  const double c = cosine - rounded * sine, k = sine + rounded * cosine;
  const auto turned = [&](auto part, Pair<double>& p, Pair<double>& q) {
    const double px = part(drive_.p.x), py = part(drive_.p.y), qx = part(drive_.q.x), qy = part(drive_.q.y);
    p = {px * c + qx * k, py * c + qy * k};
    q = {qx * c - px * k, qy * c - py * k};
  };
  in_.constant = {value(drive_.constant.x), value(drive_.constant.y)};
  turned([](const T& a) { return value(a); }, in_.p, in_.q);
  in_.kappa = value(kappa);
  in_.velocity = {value(u.x), value(u.y)};
  if constexpr (N == 0) {
    solver_(table_, in_, out_, nullptr);
  } else {
    for (int j = 0; j < N; ++j) {
      columns_.kappa[j] = kappa.d[j];
      columns_.velocity.x[j] = u.x.d[j];
      columns_.velocity.y[j] = u.y.d[j];
      if (!columns_.drive_varies) continue;
      Pair<double> p, q;
      turned([j](const T& a) { return a.d[j]; }, p, q);
      columns_.constant.x[j] = drive_.constant.x.d[j];
      columns_.constant.y[j] = drive_.constant.y.d[j];
      columns_.p.x[j] = p.x;
      columns_.p.y[j] = p.y;
      columns_.q.x[j] = q.x;
      columns_.q.y[j] = q.y;
    }
    solver_(table_, in_, out_, &columns_);
  }
}

template <class T>
void ArcStepper<T>::take(Pair<T>& u, Pair<T>& moved) const {
  if constexpr (N == 0) {
    u = out_.velocity;
    moved = out_.displacement;
  } else {
    u = {T(out_.velocity.x), T(out_.velocity.y)};
    moved = {T(out_.displacement.x), T(out_.displacement.y)};
    for (int j = 0; j < N; ++j) {
      u.x.d[j] = columns_.velocity.x[j];
      u.y.d[j] = columns_.velocity.y[j];
      moved.x.d[j] = columns_.displacement.x[j];
      moved.y.d[j] = columns_.displacement.y[j];
    }
  }
}

template <class T>
Pair<T> ArcStepper<T>::direction(int i) const {
  Pair<T> n{T(out_.direction_x[i]), T(out_.direction_y[i])};
  if constexpr (N > 0)
    for (int j = 0; j < N; ++j) {
      n.x.d[j] = -columns_.turn[i][j] * out_.direction_y[i];
      n.y.d[j] = columns_.turn[i][j] * out_.direction_x[i];
    }
  return n;
}

}  // namespace tribotrack::model::internal
