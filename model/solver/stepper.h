// Eq. (5) integrated between two pulse edges, where mu is constant: advance() holds a sticking part to its
// release and carries a slipping one by long arcs, Taylor series, or, near zero speed, in polar coordinates
// to a stop.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "model/arcs/arc_stepper.h"
#include "model/equation/edges.h"
#include "model/equation/stick.h"
#include "model/series/rest_series.h"
#include "model/solver/piece.h"
#include "model/trajectory.h"

namespace tribotrack::model::internal {

/// The input of one run.
template <class T>
struct SolverInput {
  ScaledProblem<T> problem;
  Edges<T> edges;
  bool circling = false;  ///< a pulse already open at the start does not count
  Pair<T> velocity;       ///< at the start
  T start_shift{};        ///< derivatives of the start phase (value 0)
  /// `velocity` lies on one motion whatever the start phase: it does not shift with it.
  bool on_orbit = false;
  double contraction = HUGE_VAL;  ///< per cycle of that motion
  double cycles = 0, rest = 0;    ///< the run ends `rest` after so many whole cycles
  double tolerance = 1e-16;
  bool dense = false;  ///< keep the pieces
  bool reuse = true;   ///< of repeating cycles
  long max_steps = 0;
};

/// Of implicit steps, grows where they succeed.
inline constexpr double kFirstSlowSpan = 0.5;

/// Below this fraction of (|d| + kappa) the speed is small: polar coordinates pay.
inline constexpr double kSmallSpeed = 0.08;
/// Speeds below this count as zero (scaled units; what they move is below rounding).
inline constexpr double kZeroSpeed = 1e-17;
/// Below this fraction of kappa creeping is stiff for an explicit method.
inline constexpr double kStiffSpeed = 0.02;

/// The friction at one time.
struct Contact {
  bool reduced = false;  ///< mu2 holds
  bool sticks = false;
};

/// What a stretch of a run cost and how often the part stopped in it.
struct StepCounts {
  long steps = 0;
  double stops = 0, releases = 0, stick_phase = 0;
};

/// Carries U, X (with derivatives at fixed s) from phase to phase and keeps the pieces.
template <class T>
class Stepper {
 public:
  explicit Stepper(const SolverInput<T>& input)
      : problem_(input.problem),
        tolerance_(input.tolerance),
        max_steps_(input.max_steps),
        dense_(input.dense),
        order_(taylor_order(input.tolerance)),
        arcs_(problem_.drive, tolerance_, dense_) {}
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;

  /// At the phase s of cycle 0, where friction is mu1 or mu2.
  void begin(double s, bool reduced, const Pair<T>& velocity, const Pair<T>& position = {});
  /// To a later phase of the same cycle, at one friction law.
  void advance(double target);
  /// From here on the other law holds.
  void apply(const Edge<T>& edge);
  /// The same instant, counted from the next cycle's begin.
  void enter_next_cycle() {
    s_ = s_ == kTwoPi ? 0 : (s_ - kTwoPi) - kTwoPiRest;
    cycle_ += 1;
  }
  /// Past cycles that are known without being integrated.
  void skip(double cycles, const Pair<T>& velocity, const Pair<T>& displacement) {
    cycle_ += cycles;
    u_ = velocity;
    move(displacement);
  }

  double cycle() const { return cycle_; }
  const Pair<T>& velocity() const { return u_; }
  const Pair<T>& position() const { return x_; }
  const Pair<double>& rounded() const { return rounded_; }
  Contact contact() const { return contact_; }
  const ScaledDrive<T>& drive() const { return problem_.drive; }
  const T& kappa(bool reduced) const { return reduced ? problem_.kappa_reduced : problem_.kappa_nominal; }
  const PieceChain<T>& chain() const { return chain_; }
  ArcStepper<T>& arcs() { return arcs_; }

  StepCounts counts;

 private:
  void hold(double target);
  void start_from_rest(double target);
  bool glide(double target);
  void slip(double target);
  void creep_past_zero(double target);
  bool slow(double target, bool from_rest);
  void reach_zero(const T& moved);

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
  bool at_rest() const { return value(u_.x) == 0 && value(u_.y) == 0; }
  const T& kappa() const { return kappa(reduced_); }
  bool small_speed() const;
  double strength() const { return length(values(drive()).at(s_)) + value(kappa()); }
  /// What strength() cannot exceed.
  double strength_bound() const { return drive_bound_ + value(kappa()); }
  void count_step() {
    if (++counts.steps > max_steps_)
      throw StepLimitExceeded("the motion takes more than max_steps = " + std::to_string(max_steps_) +
                              " steps to follow: too many cycles, or friction next to nothing");
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

  ScaledProblem<T> problem_;
  double tolerance_;
  long max_steps_;
  bool dense_;
  int order_;
  ArcStepper<T> arcs_;
  PieceChain<T> chain_;
  double cycle_ = 0, s_ = 0;
  bool reduced_ = false;
  Contact contact_;     ///< during the last step
  bool stuck_ = false;  ///< stopped and held since it last moved
  Pair<T> u_, x_;
  Pair<double> rounded_;  ///< what x_ has lost by rounding (Kahan's sum)
  double slow_span_ = kFirstSlowSpan;
  double drive_bound_ = 0;
};

template <class T>
void Stepper<T>::begin(double s, bool reduced, const Pair<T>& velocity, const Pair<T>& position) {
  s_ = s;
  reduced_ = reduced;
  u_ = velocity;
  x_ = position;
  arcs_.begin_segment(reduced_);
  drive_bound_ = length(drive().constant) +
                 std::sqrt(value(dot(drive().p, drive().p)) + value(dot(drive().q, drive().q)));
}

/// U is the same on both sides of the edge; an edge at another phase acts a little earlier or later.
template <class T>
void Stepper<T>::apply(const Edge<T>& edge) {
  if (edge.opens == reduced_) return;
  const Pair<T> before = force(drive(), kappa(), s_, u_);
  reduced_ = edge.opens;
  const Pair<T> after = force(drive(), kappa(), s_, u_);
  u_ = u_ + edge.change * (before - after);
  arcs_.begin_segment(reduced_);
}

template <class T>
void Stepper<T>::advance(double target) {
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
void Stepper<T>::hold(double target) {
  const Excess excess(drive(), value(kappa()));
  if (excess.holds(s_)) {
    const double until = excess.release(s_, target);
    Piece<T> piece = begin_piece();
    piece.span = until - s_;
    contact_.sticks = true;
    arcs_.forget();
    slow_span_ = kFirstSlowSpan;
    if (dense_) chain_.add_stick(piece);
    u_ = {};
    counts.stick_phase += until - s_;
    s_ = until;
    if (until >= target) return;
  }
  if (stuck_) counts.releases += 1;
  stuck_ = false;
  start_from_rest(target);
}

template <class T>
void Stepper<T>::start_from_rest(double target) {
  using std::sqrt;
  const Pair<T> d = drive().at(s_);
  const double norm = length(d), surplus = norm - value(kappa());
  if (surplus < 0.02 * norm && slow(target, true)) return;
  const T speed = sqrt(dot(d, d)) - kappa();
  Piece<T> piece = begin_piece();
  // U = 0 with derivatives along the drive is a start a little earlier or later.
  piece.shift = change(T((u_.x * d.x + u_.y * d.y) / (speed * -norm)));
  SlipSeries<T> series;
  expand_from_rest(shifted(drive(), s_ + piece.shift), kappa(), order_, series);
  const double reach = std::fmin(target - s_, series.step(tolerance_, 1));
  const double h = series.stays_above(0.2 * series.square[0], reach);
  piece.span = h;
  const T t = h - piece.shift;
  if (dense_) chain_.add(piece, series);
  u_ = {evaluate(series.x, order_, t), evaluate(series.y, order_, t)};
  move({evaluate_integral(series.x, order_, t), evaluate_integral(series.y, order_, t)});
  s_ = h < target - s_ ? s_ + h : target;
}

template <class T>
bool Stepper<T>::small_speed() const {
  if (derivative_count<T> == 0 && value(kappa()) == 0) return false;
  const double ux = value(u_.x), uy = value(u_.y), most = kSmallSpeed * strength_bound();
  return ux * ux + uy * uy < most * most && length(u_) < kSmallSpeed * strength();
}

/// One arc; false where no arc will do.
template <class T>
bool Stepper<T>::glide(double target) {
  if (value(kappa()) == 0) return false;
  Piece<T> piece = new_piece();
  piece.velocity = u_;
  Pair<T> moved;
  if (!arcs_.advance(s_, target, kappa(), kSmallSpeed * strength_bound(), u_, moved)) return false;
  move(moved);
  count_step();
  piece.span = s_ - piece.s;
  if (dense_) chain_.add(piece, arcs_);
  return true;
}

template <class T>
void Stepper<T>::slip(double target) {
  Piece<T> piece = begin_piece();
  SlipSeries<T> series;
  series.expand(drive(), kappa(), s_, u_, order_);
  // Not below what rounding leaves of |U|^2 where it runs through 0.
  const double small = std::fmax(0.9 * kSmallSpeed * strength(), 3e-7 * std::sqrt(series.square[0]));
  const double reach = std::fmin(target - s_, series.step(tolerance_));
  const double h = series.stays_above(std::fmin(small * small, 0.5 * series.square[0]), reach);
  piece.span = h;
  if (dense_) chain_.add(piece, series);
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
void Stepper<T>::creep_past_zero(double target) {
  if (length(u_) < kZeroSpeed) return reach_zero(T{});
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
      const Motion<T> motion = at_fixed_phase(state, drive(), kappa());
      u_ = motion.velocity;
      x_ = motion.position;
      if (slow(target, false)) return;
    }
    series.expand(drive(), kappa(), state, order_);
    Piece<T> piece = begin_piece();
    piece.span = series.step(tolerance_);
    PolarState<T> next = series.at(piece.span);
    const bool hit = value(next.s) >= target;
    if (hit) {
      piece.span = series.solve(target, piece.span);
      next = series.at(piece.span);
    }
    if (dense_) chain_.add(piece, series);
    state = next;
    s_ = hit ? target : value(state.s);
    state.s = with_value(state.s, s_);
    const Motion<T> motion = at_fixed_phase(state, drive(), kappa());
    u_ = motion.velocity;
    x_ = motion.position;
    const double speed = std::exp(value(state.log_speed));
    if (speed < kZeroSpeed) return reach_zero(change(state.s));
    if (speed > 1.25 * kSmallSpeed * strength()) return;
  }
}

/// u = 0 at s, a phase that has derivatives `moved`: held from now on, or driven through.
template <class T>
void Stepper<T>::reach_zero(const T& moved) {
  u_ = {};
  if (Excess(drive(), value(kappa())).holds(s_)) {
    counts.stops += 1;
    stuck_ = true;
  } else {
    const Pair<T> after = force(drive(), kappa(), s_, u_);
    u_ = Pair<T>{} - moved * after;
  }
}

/// One implicit step; false if this is not (yet) a case for it.
template <class T>
bool Stepper<T>::slow(double target, bool from_rest) {
  using std::cos;
  using std::sin;
  const Pair<double> d = values(drive()).at(s_);
  const double mu = value(kappa());
  T speed, angle;
  if (from_rest) {
    const Pair<T> along = drive().at(s_);
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
    step = slow_step(drive(), kappa(), s_, -r / rate, speed, angle, true, tolerance_);
  if (step && step->span > left) step.reset();
  const double shortest = from_rest ? 1e-9 : 10 * r / mu;
  double span = std::fmin(left, slow_span_);
  for (int i = 0; !step && span > 0 && i < 30; ++i) {
    step = slow_step(drive(), kappa(), s_, span, speed, angle, false, tolerance_);
    if (step) {
      slow_span_ = std::fmin(2.0, 2 * span);
      break;
    }
    span *= 0.5;
    if (span < shortest || (!from_rest && i == 4)) break;
  }
  if (!step) {
    slow_span_ = kFirstSlowSpan;
    return false;
  }
  Piece<T> piece = begin_piece();
  piece.span = step->span;
  step->x0 = x_.x;
  step->y0 = x_.y;
  if (dense_) chain_.add(piece, *step);
  const auto p = step->at(step->span);
  x_ = {p.x, p.y};
  s_ = step->span < left ? s_ + step->span : target;
  if (step->stops) {
    reach_zero(T{});
  } else {
    u_ = {p.speed * cos(p.angle), p.speed * sin(p.angle)};
  }
  return true;
}

}  // namespace tribotrack::model::internal
