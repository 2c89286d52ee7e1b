// One run through its cycles, edges, stops and releases.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "model/internal/arc_stepper.h"
#include "model/internal/edges.h"
#include "model/internal/piece.h"
#include "model/internal/repetition.h"
#include "model/internal/rest_series.h"
#include "model/internal/stick.h"
#include "model/trajectory.h"

namespace tribotrack::model::internal {

/// Everything the solver is told.
template <class T>
struct SolverInput {
  ScaledProblem<T> problem;
  Edges<T> edges;
  bool circling = false;  ///< a pulse already open at the start does not count
  Pair<T> velocity;       ///< at the start
  T start_shift{};        ///< derivatives of the start phase (value 0)
  bool on_orbit =
      false;  ///< `velocity` lies on one motion whatever the start phase: it does not shift with it
  double contraction = HUGE_VAL;  ///< per cycle of that motion
  double cycles = 0, rest = 0;    ///< the run ends `rest` after so many whole cycles
  double tolerance = 1e-16;
  bool dense = false;  ///< keep the pieces
  bool reuse = true;   ///< of repeating cycles
  long max_steps = 0;
};

/// The same input without its derivatives by the parameters, and room for others.
template <class U, class T>
SolverInput<U> lifted(const SolverInput<T>& in) {
  const auto number = [](const T& a) { return U(value(a)); };
  const auto pair = [&](const Pair<T>& a) { return Pair<U>{number(a.x), number(a.y)}; };
  SolverInput<U> out;
  const ScaledProblem<T>& p = in.problem;
  out.problem = {{pair(p.drive.constant), pair(p.drive.p), pair(p.drive.q)},
                 number(p.kappa_nominal),
                 number(p.kappa_reduced),
                 p.velocity_unit};
  out.edges.count = in.edges.count;
  out.edges.open_at_start = in.edges.open_at_start;
  for (int i = 0; i < in.edges.count; ++i)
    out.edges.edge[i] = {in.edges.edge[i].s, U{}, in.edges.edge[i].opens};
  out.circling = in.circling;
  out.velocity = pair(in.velocity);
  out.cycles = in.cycles;
  out.rest = in.rest;
  out.tolerance = in.tolerance;
  out.max_steps = in.max_steps;
  return out;
}

/// The friction at one time.
struct Contact {
  bool reduced = false;  ///< mu2 holds
  bool sticks = false;
};

/// Carries U, X (with derivatives at fixed s) from the start to the end and keeps the pieces.
template <class T>
class Solver {
 public:
  explicit Solver(const SolverInput<T>& input)
      : in_(input),
        drive_(input.problem.drive),
        order_(taylor_order(input.tolerance)),
        arcs_(drive_, in_.tolerance, in_.dense),
        shrinking_(in_.contraction) {}
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  void run();
  /// One cycle from (s, u), s either 0 or where run_cycle() ends, where friction is mu1 or mu2, to the same
  /// phase of the next, with its derivatives by u. `spans` is what is known of the length of arcs, before and
  /// after.
  CycleMap map_cycle(double s, bool reduced, const Pair<double>& u, ArcSpans& spans);
  Motion<T> end() const { return {u_, x_}; }
  /// Motion at the local phase s of a cycle, derivatives at fixed s.
  Motion<T> at(double cycle, double s) const;
  /// Which friction holds, and whether it holds the part, at a phase of a dense run and at the end.
  Contact contact(double cycle, double s) const {
    const Piece<T>& piece = chain_.find(source_cycle(cycle), s);
    return {piece.reduced, piece.kind == PieceKind::stick};
  }
  Contact end_contact() const { return contact_; }
  const ScaledDrive<T>& drive() const { return drive_; }
  const T& kappa(bool reduced) const {
    return reduced ? in_.problem.kappa_reduced : in_.problem.kappa_nominal;
  }

  long steps = 0;
  double stops = 0, releases = 0, stick_phase = 0;
  double error_bound = 0;  ///< of X at the end, from cycles that were not integrated

 private:
  struct CycleStart {
    double gap = 0;  ///< of its velocity to the one before
    Pair<T> u, x;
    Pair<double> rounded;
    long steps = 0;
    double stops = 0, releases = 0, stick_phase = 0;
  };

  void begin(double s, bool reduced);
  void run_cycle();
  void run_until(double s);
  void pass_edges(double until);
  void advance(double target);
  void hold(double target);
  void start_from_rest(double target);
  bool glide(double target);
  void slip(double target);
  void creep_past_zero(double target);
  bool slow(double target, bool from_rest);
  void reach_zero(const T& moved, const Pair<T>& force_before);
  void apply(const Edge<T>& edge);
  void skip_repeating_cycles();
  void extrapolate_cycles(const Pair<T>& previous_start, double allowed);

  void move(const Pair<T>& by) {
    move(by.x, x_.x, rounded_.x);
    move(by.y, x_.y, rounded_.y);
  }
  static void move(const T& by, T& sum, double& rounded) {
    const double before = value(sum), wanted = value(by) + rounded;
    sum += by;
    sum = with_value(sum, before + wanted);
    rounded = wanted - (value(sum) - before);
  }
  Pair<T> drift_since(const CycleStart& start) const {
    return (x_ - start.x) + Pair<T>{T(rounded_.x - start.rounded.x), T(rounded_.y - start.rounded.y)};
  }
  bool at_rest() const { return value(u_.x) == 0 && value(u_.y) == 0; }
  const T& kappa() const { return kappa(reduced_); }
  bool small_speed() const;
  double strength() const { return length(drive_.value_at(s_)) + value(kappa()); }
  /// What strength() cannot exceed.
  double strength_bound() const { return drive_bound_ + value(kappa()); }
  double source_cycle(double cycle) const {
    return cycle >= repeat_from_ && cycle < repeat_to_ ? repeat_from_ - 1 : cycle;
  }
  void count_step() {
    if (++steps > in_.max_steps)
      throw std::runtime_error("integrate: more than max_steps = " + std::to_string(in_.max_steps) +
                               " steps; raise IntegrationOptions::max_steps or shorten the run");
    contact_ = {reduced_, false};
  }
  Piece<T> begin_piece() {
    count_step();
    return new_piece();
  }
  Piece<T> new_piece() const {
    Piece<T> piece;
    piece.cycle = cycle_;
    piece.s = s_;
    piece.reduced = reduced_;
    piece.position = x_;
    return piece;
  }

  SolverInput<T> in_;
  ScaledDrive<T> drive_;
  int order_;
  ArcStepper<T> arcs_;
  PieceChain<T> chain_;
  double cycle_ = 0, s_ = 0;
  bool reduced_ = false;
  Contact contact_;     ///< during the last step
  bool stuck_ = false;  ///< stopped and held since it last moved
  Pair<T> u_, x_;
  Pair<double> rounded_;  ///< what x_ has lost by rounding (Kahan's sum)
  double slow_span_ = 0.5;
  double drive_bound_ = 0;
  // Cycles repeat_from_ .. repeat_to_ - 1 are copies of the one before.
  double repeat_from_ = HUGE_VAL, repeat_to_ = HUGE_VAL;
  Pair<T> repeat_drift_;
  CycleStart last_start_;
  Shrinking shrinking_;
};

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

/// Below this fraction of (|d| + kappa) the speed is small: polar coordinates pay.
inline constexpr double kSmallSpeed = 0.08;
/// Speeds below this count as zero (scaled units; what they move is below rounding).
inline constexpr double kZeroSpeed = 1e-17;
/// Below this fraction of kappa creeping is stiff for an explicit method.
inline constexpr double kStiffSpeed = 0.02;

template <class T>
void Solver<T>::begin(double s, bool reduced) {
  s_ = s;
  reduced_ = reduced;
  arcs_.begin_segment(reduced_);
  drive_bound_ =
      length(drive_.constant) + std::sqrt(value(dot(drive_.p, drive_.p)) + value(dot(drive_.q, drive_.q)));
}

template <class T>
void Solver<T>::run() {
  begin(0, in_.edges.open_at_start && !in_.circling);
  const Pair<T> f = force(drive_, kappa(), 0.0, in_.velocity);
  u_ = in_.on_orbit ? in_.velocity : in_.velocity - in_.start_shift * f;
  x_ = Pair<T>{} - in_.start_shift * in_.velocity;
  while (cycle_ < in_.cycles) {
    if (cycle_ >= 1 && in_.reuse) skip_repeating_cycles();
    if (cycle_ < in_.cycles) run_cycle();
  }
  run_until(in_.rest);
}

/// To the same phase of the next cycle. Where nobody asks for the time between, that is the last edge's: the
/// stretch from there to the next cycle's first edge is one.
template <class T>
void Solver<T>::run_cycle() {
  pass_edges(kTwoPi);
  if (in_.dense || in_.edges.count == 0) {
    advance(kTwoPi);
    s_ = 0;
  } else {
    s_ = (s_ - kTwoPi) - kTwoPiRest;
  }
  cycle_ += 1;
}

template <class T>
void Solver<T>::run_until(double s) {
  pass_edges(s);
  advance(s);
}

template <class T>
void Solver<T>::pass_edges(double until) {
  for (int i = 0; i < in_.edges.count; ++i) {
    const Edge<T>& edge = in_.edges.edge[i];
    if (edge.s >= until) break;
    advance(edge.s);
    apply(edge);
  }
}

/// U is the same on both sides of the edge; an edge at another phase acts a little earlier or later.
template <class T>
void Solver<T>::apply(const Edge<T>& edge) {
  if (edge.opens == reduced_) return;
  const Pair<T> before = force(drive_, kappa(), s_, u_);
  reduced_ = edge.opens;
  const Pair<T> after = force(drive_, kappa(), s_, u_);
  u_ = u_ + edge.change * (before - after);
  arcs_.begin_segment(reduced_);
}

template <class T>
void Solver<T>::advance(double target) {
  while (s_ < target) {
    if (at_rest())
      hold(target);
    else if (small_speed())
      creep_past_zero(target);
    else if (!glide(target))
      slip(target);
  }
}

template <class T>
void Solver<T>::hold(double target) {
  const Excess excess(drive_, value(kappa()));
  if (excess.holds(s_)) {
    const double until = excess.release(s_, target);
    Piece<T> piece = begin_piece();
    piece.span = until - s_;
    contact_.sticks = true;
    arcs_.forget();
    if (in_.dense) chain_.add_stick(piece);
    u_ = {};
    stick_phase += until - s_;
    s_ = until;
    if (until >= target) return;
  }
  if (stuck_) releases += 1;
  stuck_ = false;
  start_from_rest(target);
}

template <class T>
void Solver<T>::start_from_rest(double target) {
  using std::sqrt;
  const Pair<T> d = drive_.at(s_);
  const double norm = length(d), surplus = norm - value(kappa());
  if (surplus < 0.02 * norm && slow(target, true)) return;
  const T speed = sqrt(dot(d, d)) - kappa();
  Piece<T> piece = begin_piece();
  // U = 0 with derivatives along the drive is a start a little earlier or later.
  piece.shift = change(T((u_.x * d.x + u_.y * d.y) / (speed * -norm)));
  SlipSeries<T> series;
  expand_from_rest(shifted(drive_, s_ + piece.shift), kappa(), order_, series);
  const double reach = std::fmin(target - s_, series.step(in_.tolerance, 1));
  const double h = series.stays_above(0.2 * series.square[0], reach);
  piece.span = h;
  const T t = h - piece.shift;
  if (in_.dense) chain_.add(piece, series);
  u_ = {evaluate(series.x, order_, t), evaluate(series.y, order_, t)};
  move({evaluate_integral(series.x, order_, t), evaluate_integral(series.y, order_, t)});
  s_ = h < target - s_ ? s_ + h : target;
}

template <class T>
bool Solver<T>::small_speed() const {
  if (derivative_count<T> == 0 && value(kappa()) == 0) return false;
  const double ux = value(u_.x), uy = value(u_.y), most = kSmallSpeed * strength_bound();
  return ux * ux + uy * uy < most * most && length(u_) < kSmallSpeed * strength();
}

/// One arc; false where no arc will do.
template <class T>
bool Solver<T>::glide(double target) {
  if (value(kappa()) == 0) return false;
  Piece<T> piece = new_piece();
  piece.velocity = u_;
  Pair<T> moved;
  if (!arcs_.advance(s_, target, kappa(), kSmallSpeed * strength_bound(), u_, moved)) return false;
  move(moved);
  count_step();
  piece.span = s_ - piece.s;
  if (in_.dense) chain_.add(piece, arcs_);
  return true;
}

template <class T>
void Solver<T>::slip(double target) {
  Piece<T> piece = begin_piece();
  SlipSeries<T> series;
  series.expand(drive_, kappa(), s_, u_, order_);
  const double small = 0.9 * kSmallSpeed * strength();
  const double reach = std::fmin(target - s_, series.step(in_.tolerance));
  const double h = series.stays_above(std::fmin(small * small, 0.5 * series.square[0]), reach);
  piece.span = h;
  if (in_.dense) chain_.add(piece, series);
  u_ = {evaluate(series.x, order_, h), evaluate(series.y, order_, h)};
  move({evaluate_integral(series.x, order_, h), evaluate_integral(series.y, order_, h)});
  s_ = h < target - s_ ? s_ + h : target;
}

/// log|u| and the angle of u, without squaring tiny numbers.
template <class T>
void to_polar(const Pair<T>& u, T& log_speed, T& angle) {
  const double norm = length(u), ux = value(u.x) / norm, uy = value(u.y) / norm;
  log_speed = with_value(T((u.x * ux + u.y * uy) / norm), std::log(norm));
  angle = with_value(T((u.y * ux - u.x * uy) / norm), std::atan2(uy, ux));
}

template <class T>
void Solver<T>::creep_past_zero(double target) {
  if (length(u_) < kZeroSpeed) return reach_zero(T{}, force(drive_, kappa(), s_, u_));
  // Where the implicit step fails it is tried again after ever more steps.
  int steps_until_slow = 0, patience = 3;
  PolarState<T> state;
  state.s = T(s_);
  state.x = x_.x;
  state.y = x_.y;
  to_polar(u_, state.log_speed, state.angle);
  PolarSeries<T> series;
  while (s_ < target) {
    const double r = std::exp(value(state.log_speed));
    if (r < kStiffSpeed * value(kappa()) && steps_until_slow-- <= 0) {
      steps_until_slow = patience;
      patience = std::min(2 * patience, 48);
      const Motion<T> motion = at_fixed_phase(state, drive_, kappa());
      u_ = motion.velocity;
      x_ = motion.position;
      if (slow(target, false)) return;
    }
    series.expand(drive_, kappa(), state, order_);
    Piece<T> piece = begin_piece();
    piece.span = series.step(in_.tolerance);
    PolarState<T> next = series.at(piece.span);
    const bool hit = value(next.s) >= target;
    if (hit) {
      piece.span = series.solve(target, piece.span);
      next = series.at(piece.span);
    }
    if (in_.dense) chain_.add(piece, series);
    state = next;
    s_ = hit ? target : value(state.s);
    state.s = with_value(state.s, s_);
    const Motion<T> motion = at_fixed_phase(state, drive_, kappa());
    u_ = motion.velocity;
    x_ = motion.position;
    const double speed = std::exp(value(state.log_speed));
    if (speed < kZeroSpeed) {
      using std::cos;
      using std::sin;
      const Pair<T> d = drive_.at(s_);
      return reach_zero(change(state.s),
                        {d.x - kappa() * cos(state.angle), d.y - kappa() * sin(state.angle)});
    }
    if (speed > 1.25 * kSmallSpeed * strength()) return;
  }
}

/// u = 0 at s, a phase that has derivatives `moved`: held from now on, or driven through.
template <class T>
void Solver<T>::reach_zero(const T& moved, const Pair<T>&) {
  u_ = {};
  if (Excess(drive_, value(kappa())).holds(s_)) {
    stops += 1;
    stuck_ = true;
  } else {
    const Pair<T> after = force(drive_, kappa(), s_, u_);
    u_ = Pair<T>{} - moved * after;
  }
}

/// One implicit step; false if this is not (yet) a case for it.
template <class T>
bool Solver<T>::slow(double target, bool from_rest) {
  using std::cos;
  using std::sin;
  const Pair<double> d = drive_.value_at(s_);
  const double mu = value(kappa());
  T speed, angle;
  if (from_rest) {
    const Pair<T> along = drive_.at(s_);
    T ignored;
    to_polar(along, ignored, angle);
    speed = with_value(T((u_.x * d.x + u_.y * d.y) / length(d)), 0.0);
  } else {
    T log_speed;
    to_polar(u_, log_speed, angle);
    const double norm = length(u_);
    speed = with_value(T(log_speed * norm), norm);
  }
  const double r = value(speed), c = std::cos(value(angle)), k = std::sin(value(angle));
  const double rate = d.x * c + d.y * k - mu, across = d.y * c - d.x * k;
  if (!from_rest && (std::fabs(rate) > 0.3 * mu || std::fabs(across) > 5 * r)) return false;
  const double left = target - s_;
  std::optional<SlowStep<T>> step;
  if (rate < 0 && -r / rate < std::fmin(left, 0.5))
    step = slow_step(drive_, kappa(), s_, -r / rate, speed, angle, true, in_.tolerance);
  if (step && step->span > left) step.reset();
  const double shortest = from_rest ? 1e-9 : 10 * r / mu;
  double span = std::fmin(left, slow_span_);
  for (int i = 0; !step && span > 0 && i < 30; ++i) {
    step = slow_step(drive_, kappa(), s_, span, speed, angle, false, in_.tolerance);
    if (step) {
      slow_span_ = std::fmin(2.0, 2 * span);
      break;
    }
    span *= 0.5;
    if (span < shortest || (!from_rest && i == 4)) break;
  }
  if (!step) {
    slow_span_ = 0.5;
    return false;
  }
  Piece<T> piece = begin_piece();
  piece.span = step->span;
  step->x0 = x_.x;
  step->y0 = x_.y;
  if (in_.dense) chain_.add(piece, *step);
  const auto p = step->at(step->span);
  x_ = {p.x, p.y};
  s_ = step->span < left ? s_ + step->span : target;
  if (step->stops) {
    reach_zero(T{}, {});
  } else {
    u_ = {p.speed * cos(p.angle), p.speed * sin(p.angle)};
  }
  return true;
}

/// Once a cycle begins as the last one did, all later ones are copies and only add their drift.
template <class T>
void Solver<T>::skip_repeating_cycles() {
  const double scale = std::fmax(length(u_), 1e-3), copies = in_.cycles - cycle_;
  const CycleStart before = last_start_;
  last_start_ = {length(Pair<T>(u_ - before.u)), u_, x_, rounded_, steps, stops, releases, stick_phase};
  if (cycle_ < 2) return;
  const double gap = last_start_.gap, q = cycle_ > 2 && before.gap > 0 ? gap / before.gap : 1;
  const double allowed = in_.tolerance * scale * kTwoPi * in_.cycles;
  const bool exact = same(u_.x, before.u.x) && same(u_.y, before.u.y);
  const bool settled =
      shrinking_.settled(gap, before.gap, static_cast<double>(last_start_.steps - before.steps));
  const double error = settled && !exact ? shrinking_.error(gap, copies) : copying_error(gap, q, copies);
  const bool close = settled || gap <= 4e-16 * scale || error <= allowed;
  if (exact || (close && same_derivatives(u_, before.u, in_.tolerance))) {
    error_bound = error;
    repeat_from_ = cycle_;
    repeat_to_ = in_.cycles;
    repeat_drift_ = drift_since(before);
    move(T(copies) * repeat_drift_);
    stops += copies * (stops - before.stops);
    releases += copies * (releases - before.releases);
    stick_phase += copies * (stick_phase - before.stick_phase);
    cycle_ = in_.cycles;
    return;
  }
  if constexpr (derivative_count<T> == 0) {
    // Worth a try? Terms of second order in the next gap are left out.
    const double next = gap * (cycle_ > 2 ? q : 0.1);
    if (!in_.dense && stops == before.stops && next < 0.3 * gap && copies > 2 &&
        next * next * copies <= allowed)
      extrapolate_cycles(before.u, allowed);
  }
}

/// One more cycle with its dependence on where it begins, which tells of all later ones.
template <class T>
void Solver<T>::extrapolate_cycles(const Pair<T>& previous_start, double allowed) {
  Solver<Jet<2>> solver(lifted<Jet<2>>(in_));
  ArcSpans spans = arcs_.spans();
  const CycleMap map = solver.map_cycle(s_, reduced_, u_, spans);
  const Eigen::Vector2d start(u_.x, u_.y), before(u_.x - previous_start.x, u_.y - previous_start.y);
  steps += solver.steps;
  u_ = {map.end.x(), map.end.y()};
  move({map.drift.x(), map.drift.y()});
  stops += solver.stops;
  cycle_ += 1;
  const double copies = in_.cycles - cycle_;
  const Remainder rest = extrapolate(map, start, before, copies);
  if (solver.stops > 0 || !(rest.error <= allowed)) return;
  u_ = u_ + Pair<T>{rest.velocity_change.x(), rest.velocity_change.y()};
  move({rest.displacement.x(), rest.displacement.y()});
  error_bound = rest.error;
  cycle_ = in_.cycles;
}

template <class T>
CycleMap Solver<T>::map_cycle(double s, bool reduced, const Pair<double>& u, ArcSpans& spans) {
  static_assert(derivative_count<T> == 2);
  begin(s, reduced);
  arcs_.set_spans(spans);
  u_ = {T(u.x), T(u.y)};
  u_.x.d[0] = u_.y.d[1] = 1;
  if (s < 0)
    run_cycle();
  else
    run_until(kTwoPi);
  spans = arcs_.spans();
  CycleMap map;
  map.end = {u_.x.v, u_.y.v};
  map.drift = {x_.x.v, x_.y.v};
  map.jacobian << u_.x.d[0], u_.x.d[1], u_.y.d[0], u_.y.d[1];
  map.drift_slope << x_.x.d[0], x_.x.d[1], x_.y.d[0], x_.y.d[1];
  return map;
}

template <class T>
Motion<T> Solver<T>::at(double cycle, double s) const {
  const double source = source_cycle(cycle);
  const Piece<T>& piece = chain_.find(source, s);
  Motion<T> motion = chain_.at(piece, s, drive_, kappa(piece.reduced));
  if (source != cycle) motion.position = motion.position + T(cycle - source) * repeat_drift_;
  return motion;
}

}  // namespace tribotrack::model::internal
