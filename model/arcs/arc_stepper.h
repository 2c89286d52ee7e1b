// Sliding in long arcs: each solved as a whole by collocation, as long as its tolerance allows.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "model/arcs/arc.h"

namespace tribotrack::model::internal {

/// The kernel's cos and sin are good up to half of this.
inline constexpr double kLongestArc = 2.4;

/// How long the next arc may be at most: at mu1, mu2; later arcs, the first after a switch.
struct ArcSpans {
  double at[2][2];
  double failed[2][2];  ///< what was too long
};
constexpr ArcSpans spans_from(double first) {
  return {{{first, first}, {first, first}}, {{HUGE_VAL, HUGE_VAL}, {HUGE_VAL, HUGE_VAL}}};
}

/// What a cycle leaves for the next one: how long its arcs could be, and the arcs.
class ArcMemory {
 public:
  ArcSpans spans = spans_from(0);  ///< 0: nothing known yet

  /// Where the arc from s over `span` is to leave its trace (null: nowhere), and whether the last cycle left
  /// one of the same stretch.
  ArcTrace* find(double s, double span, bool reduced, int pairs, bool& known) {
    known = false;
    if (s <= last_) next_ = 0;
    while (next_ < count_ && arcs_[next_].s < s) ++next_;
    last_ = s;
    if (next_ == kMost) return nullptr;
    Arc& arc = arcs_[next_];
    known = next_ < count_ && arc.s == s && arc.span == span && arc.reduced == reduced && arc.pairs == pairs;
    if (!known) {
      arc.s = s;
      arc.span = span;
      arc.reduced = reduced;
      arc.pairs = pairs;
      count_ = std::max(count_, next_ + 1);
    }
    return &arc.trace;
  }
  /// The arc last asked for was none.
  void drop() {
    if (next_ < count_) arcs_[next_].span = 0;
  }
  void clear(double first_arc) {
    spans = spans_from(first_arc);
    count_ = 0;
  }

 private:
  static constexpr int kMost = 24;
  struct Arc {
    double s, span;
    bool reduced;
    int pairs;
    ArcTrace trace;
  };
  std::array<Arc, kMost> arcs_;
  int count_ = 0, next_ = 0;
  double last_ = HUGE_VAL;
};

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
    too_slow_ = 0;
  }
  /// One arc from the phase s towards `target`: true, s and u at its end, and by how much it moved. False,
  /// and nothing changed, where no arc resolves the motion to the tolerance or the speed falls below
  /// `slowest`.
  bool advance(double& s, double target, const T& kappa, double slowest, Pair<T>& u, Pair<T>& moved);
  /// U/|U| at node i of the last arc.
  Pair<T> direction(int i) const;
  const GaussTable& table() const { return table_; }
  /// To remember in `memory` and to begin with what it knows.
  void share(ArcMemory& memory) {
    memory_ = &memory;
    if (memory.spans.at[0][0] == 0) forget();
  }
  /// What follows must not depend on what was before.
  void forget() { memory_->clear(first_arc_); }

 private:
  static constexpr int N = derivative_count<T>;
  void solve(double s, const T& kappa, const Pair<T>& u);
  void take(Pair<T>& u, Pair<T>& moved) const;

  const ScaledDrive<T>& drive_;
  double tolerance_;
  const GaussTable& table_;
  ArcSolver* solver_;
  double growth_;     ///< of the truncation error when an arc is made kLonger times as long
  double shrinking_;  ///< of an arc by its error
  double first_arc_;  ///< as long as arcs usually can be
  ArcInput in_;
  ArcOutput out_;
  ArcColumns columns_;
  ArcMemory own_;
  ArcMemory* memory_ = &own_;
  bool reduced_ = false, first_ = true;
  double too_slow_ = 0;  ///< speed at which no arc would do, since the last switch
};

/// Arcs of 6 and of 14 nodes are about a power of the tolerance long.
inline constexpr double kUsualArc[] = {4.2, 5.8}, kUsualOrder[] = {0.12, 0.048};
inline constexpr double kShortestArc = 1e-3;
/// kappa h/|U| up to which Picard sweeps pay.
inline constexpr double kSweepable = 5;
inline constexpr double kLonger = 1.25;
/// Looser tolerances are served by 6 nodes, tighter ones by 14.
inline constexpr double kFewNodesTolerance = 1e-6;

template <class T>
ArcStepper<T>::ArcStepper(const ScaledDrive<T>& drive, double tolerance, bool keep)
    : drive_(drive),
      tolerance_(tolerance),
      table_(GaussTable::of_pairs(tolerance >= kFewNodesTolerance && !keep ? 3 : 7)),
      solver_(table_.pairs == 3 ? solve_arc_few : solve_arc_many),
      growth_(std::pow(kLonger, keep ? 2 * table_.pairs : 4 * table_.pairs + 1)),
      shrinking_(1.0 / (keep ? 2 * table_.pairs : 4 * table_.pairs + 1)),
      first_arc_(std::fmin(
          kLongestArc, kUsualArc[table_.pairs == 7] * std::pow(tolerance, kUsualOrder[table_.pairs == 7]))) {
  forget();
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
  if (speed <= too_slow_) return false;
  const double sweepable = std::fmin(kLongestArc, kSweepable * speed / value(kappa));
  double &longest = memory_->spans.at[reduced_][first_], &failed = memory_->spans.failed[reduced_][first_];
  for (int attempt = 0; attempt < 5; ++attempt) {
    if (std::fmin(longest, sweepable) < kShortestArc) break;
    const double arcs = std::ceil(left / std::fmin(longest, sweepable) - 1e-9);
    const double end = arcs > 1 ? s + left / arcs : target;
    in_.span = end - s;
    in_.tolerance = tolerance_ * speed;
    in_.resolution = tolerance_;
    in_.slowest = slowest;
    in_.rounding = 2.5e-16 / (speed * speed);
    in_.trace = memory_->find(s, in_.span, reduced_, table_.pairs, in_.traced);
    solve(s, kappa, u);
    if (out_.converged && out_.slowest < slowest) {
      memory_->drop();
      too_slow_ = speed;
      return false;
    }
    const double error = out_.error / tolerance_;
    if (out_.accepted) {
      const double longer = kLonger * in_.span;
      if (error * growth_ < 0.3 && longer < failed) longest = std::fmax(longest, longer);
      first_ = false;
      s = end;
      take(u, moved);
      return true;
    }
    memory_->drop();
    failed = 0.999 * in_.span;
    longest = in_.span * (out_.converged ? std::clamp(std::pow(0.3 / error, shrinking_), 0.3, 0.8) : 0.6);
  }
  longest = std::fmax(longest, 0.1);
  too_slow_ = speed;
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
