// Eq. (5) integrated over a run, cycle by cycle: from pulse edge to pulse edge by the Stepper (stepper.h);
// cycles that repeat are taken as copies of the last one.
#pragma once

#include <cmath>

#include "model/solver/stepper.h"
#include "model/trajectory.h"

namespace tribotrack::model::internal {

/// How gaps between successive cycles' starts shrink, and when what is left of them is rounding: they then
/// flicker at its level for ever, without two cycles that agree to the last digit.
class Shrinking {
 public:
  /// Per cycle, where it is known.
  explicit Shrinking(double contraction) : contraction_(contraction) {}

  /// Whether a gap that followed `before` after a cycle of so many steps is rounding: within what the steps'
  /// own rounding adds up to, no longer shrinking, and after a contraction that leaves no doubt about where
  /// it led; a stop on the way leaves none at once. Gaps come in their order, of the first none is `before`.
  bool settled(double gap, double before, double steps, bool stopped) {
    const double rounding = 2.3e-16 * (4 + 0.25 * steps);
    if (stopped) {
      contraction_ = 0;
    } else if (gap > rounding) {
      const double ratio = gap / before;
      contraction_ = contraction_ < HUGE_VAL ? std::sqrt(contraction_ * ratio) : ratio;
    }
    return gap <= rounding && gap > 0.5 * before && contraction_ < 0.75;
  }

 private:
  double contraction_;
};

/// Carries U, X from the start to the end of a run.
template <class T>
class Solver {
 public:
  explicit Solver(const SolverInput<T>& input) : in_(input), part_(in_), shrinking_(in_.contraction) {}

  void run();
  /// One cycle from the velocity u at the local phase 0, where friction is mu1 or mu2. `memory` is what is
  /// known of its arcs, before and after.
  Motion<T> run_one_cycle(bool reduced, const Pair<T>& u, ArcMemory& memory);
  Motion<T> end() const { return {part_.velocity(), part_.position()}; }
  /// Motion at the local phase s of a cycle, derivatives at fixed s.
  Motion<T> at(double cycle, double s) const;
  /// Which friction holds, and whether it holds the part, at a phase of a dense run and at the end.
  Contact contact(double cycle, double s) const {
    const Piece<T>& piece = part_.chain().find(source_cycle(cycle), s);
    return {piece.reduced, piece.kind == PieceKind::stick};
  }
  Contact end_contact() const { return part_.contact(); }
  const ScaledDrive<T>& drive() const { return part_.drive(); }
  const T& kappa(bool reduced) const { return part_.kappa(reduced); }
  const StepCounts& counts() const { return part_.counts; }

 private:
  struct CycleStart {
    double gap = 0;  ///< of its velocity to the one before
    Pair<T> u, x;
    Pair<double> rounded;
    StepCounts counts;
  };

  void run_cycle();
  void run_until(double s);
  void pass_edges(double until);
  void skip_repeating_cycles();
  Pair<T> drift_since(const CycleStart& start) const {
    const Pair<double>&now = part_.rounded(), &then = start.rounded;
    return (part_.position() - start.x) + Pair<T>{T(now.x - then.x), T(now.y - then.y)};
  }
  double source_cycle(double cycle) const {
    return cycle >= repeat_from_ && cycle < repeat_to_ ? repeat_from_ - 1 : cycle;
  }

  SolverInput<T> in_;
  Stepper<T> part_;
  // Cycles repeat_from_ .. repeat_to_ - 1 are copies of the one before.
  double repeat_from_ = HUGE_VAL, repeat_to_ = HUGE_VAL;
  Pair<T> repeat_drift_;
  CycleStart last_start_;
  Shrinking shrinking_;
};

template <class T>
void Solver<T>::run() {
  const bool reduced = in_.edges.open_at_start && !in_.circling;
  const T& kappa = part_.kappa(reduced);
  const Pair<T> f = force(part_.drive(), kappa, 0.0, in_.velocity);
  const Pair<T> u = in_.on_orbit ? in_.velocity : in_.velocity - in_.start_shift * f;
  part_.begin(0, reduced, u, Pair<T>{} - in_.start_shift * in_.velocity);
  while (part_.cycle() < in_.cycles) {
    if (part_.cycle() >= 1 && in_.reuse) skip_repeating_cycles();
    if (part_.cycle() < in_.cycles) run_cycle();
  }
  run_until(in_.rest);
}

/// To the same phase of the next cycle. Without dense output that is the last edge's phase, so that the
/// stretch from there to the next cycle's first edge is a single one.
template <class T>
void Solver<T>::run_cycle() {
  pass_edges(kTwoPi);
  if (in_.dense || in_.edges.count == 0) part_.advance(kTwoPi);
  part_.enter_next_cycle();
}

template <class T>
void Solver<T>::run_until(double s) {
  pass_edges(s);
  part_.advance(s);
}

template <class T>
void Solver<T>::pass_edges(double until) {
  for (int i = 0; i < in_.edges.count; ++i) {
    const Edge<T>& edge = in_.edges.edge[i];
    if (edge.s >= until) break;
    part_.advance(edge.s);
    part_.apply(edge);
  }
}

/// To 1e-13, or the tolerance, of the largest.
template <class T>
bool same_derivatives(const Pair<T>& a, const Pair<T>& b, double tolerance) {
  if constexpr (derivative_count < T >> 0) {
    for (int j = 0; j < derivative_count<T>; ++j) {
      const double size = std::hypot(a.x.d[j], a.y.d[j]);
      if (std::hypot(a.x.d[j] - b.x.d[j], a.y.d[j] - b.y.d[j]) > std::fmax(1e-13, tolerance) * size + 1e-15)
        return false;
    }
  }
  return true;
}

/// Once a cycle begins as the last one did, all later ones are copies and only add their drift.
template <class T>
void Solver<T>::skip_repeating_cycles() {
  const Pair<T> u = part_.velocity();
  const double scale = std::fmax(length(u), 1e-3), copies = in_.cycles - part_.cycle();
  const CycleStart before = last_start_;
  last_start_ = {length(Pair<T>(u - before.u)), u, part_.position(), part_.rounded(), part_.counts};
  if (part_.cycle() < 2) return;
  const StepCounts &now = last_start_.counts, &then = before.counts;
  const double gap = last_start_.gap, q = part_.cycle() > 2 && before.gap > 0 ? gap / before.gap : 1;
  // How far a cycle's velocity may be from the one it stands for. The flow of the velocity is a contraction:
  // where gaps shrink by q all further cycles begin within gap/(1 - q).
  const double allowed = in_.tolerance * scale;
  const bool exact = same(u.x, before.u.x) && same(u.y, before.u.y);
  const bool settled = shrinking_.settled(gap, before.gap, static_cast<double>(now.steps - then.steps),
                                          now.stops > then.stops);
  const bool close = settled || gap <= 4e-16 * scale || (q < 1 && gap <= (1 - q) * allowed);
  if (exact || (close && same_derivatives(u, before.u, in_.tolerance))) {
    repeat_from_ = part_.cycle();
    repeat_to_ = in_.cycles;
    repeat_drift_ = drift_since(before);
    part_.skip(copies, u, T(copies) * repeat_drift_);
    part_.counts.stops += copies * (now.stops - then.stops);
    part_.counts.releases += copies * (now.releases - then.releases);
    part_.counts.stick_phase += copies * (now.stick_phase - then.stick_phase);
    return;
  }
}

template <class T>
Motion<T> Solver<T>::run_one_cycle(bool reduced, const Pair<T>& u, ArcMemory& memory) {
  part_.begin(0, reduced, u);
  part_.arcs().share(memory);
  run_until(kTwoPi);
  return end();
}

template <class T>
Motion<T> Solver<T>::at(double cycle, double s) const {
  const double source = source_cycle(cycle);
  const Piece<T>& piece = part_.chain().find(source, s);
  Motion<T> motion = part_.chain().at(piece, s, drive(), kappa(piece.reduced));
  if (source != cycle) motion.position = motion.position + T(cycle - source) * repeat_drift_;
  return motion;
}

}  // namespace tribotrack::model::internal
