#include "model/batch/lane_run.h"

#include <Eigen/Core>
#include <algorithm>
#include <limits>

#include "model/alpha_v.h"
#include "model/equation/matrix2.h"

namespace tribotrack::model::internal {
namespace {

/// alpha, NaN where nothing has moved.
double direction(const Eigen::Vector2d& moved) {
  return moved.norm() > 0 ? displacement_angle(moved) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Need LaneRun::set_off(double kappa, double left) {
  lane.kappa = kappa;
  lane.left = left;
  finishing_ = false;
  if (!(left > 0)) {
    lane.left = 0;
    return Need::edge;
  }
  patience_ = 300 + static_cast<int>(30 * std::fmin(left, 1e6));
  if (!at_rest()) return Need::slide;
  if (kappa >= 1 + 1e-12) {
    lane.left = 0;
    return Need::edge;
  }
  if (kappa > 1 - kMarginal) return Need::scalar;
  return Need::start;
}

Need LaneRun::look(Need kind) {
  ++steps;
  if (kind == Need::creep && lane.left < 0) {
    lane.left = -lane.left;
    finishing_ = true;
    return Need::slide;
  }
  if (lane.left == 0) return Need::edge;
  if (--patience_ < 0) return Need::scalar;
  const double square = lane.vx * lane.vx + lane.vy * lane.vy;
  if (!(square < 1e8)) return Need::scalar;
  if (kind == Need::creep) {
    if (square > kSlideAbove * kSlideAbove) return Need::slide;
    const double slow = kStopBelow * std::fmin(1, lane.kappa - 1);
    if (slow > 0 && square < slow * slow) return stop() ? Need::edge : Need::scalar;
    return Need::creep;
  }
  return square < kCreepBelow * kCreepBelow && !finishing_ ? Need::creep : Need::slide;
}

/// As r -> 0 the equations in sigma become linear, p = r + v_x, q = r - v_x and v_y fall at rates kappa - 1,
/// kappa + 1 and kappa, and the way and the time to rest are integrals of r v and r. What that leaves out is
/// smaller by another r. Held from then on until the edge. False if the edge may come first.
bool LaneRun::stop() {
  const double k = lane.kappa, r = std::hypot(lane.vx, lane.vy), p = r + lane.vx, q = r - lane.vx;
  const double time = 0.5 * (p / (k - 1) + q / (k + 1));
  if (lane.left < 2 * time) return false;
  const double x = lane.zx + 0.125 * (p * p / (k - 1) - q * q / (k + 1));
  const double y = lane.zy + 0.5 * lane.vy * (p / (2 * k - 1) + q / (2 * k + 1));
  const double c = std::cos(lane.left), s = std::sin(lane.left);
  lane.zx = x * c + y * s;
  lane.zy = y * c - x * s;
  for (int i = 0; i < 2; ++i) {
    const double a = lane.yx[i], b = lane.yy[i];
    lane.yx[i] = a * c + b * s;
    lane.yy[i] = b * c - a * s;
    lane.ux[i] = lane.uy[i] = 0;
  }
  lane.vx = lane.vy = 0;
  lane.left = 0;
  return true;
}

Need EndRun::begin(const Scenario& scenario, const BatchOptions& options) {
  if (scenario.start == Start::steady) return Need::scalar;
  const auto frame = turning_frame(scenario);
  if (!frame) return Need::scalar;
  frame_ = *frame;
  end_time_ = scenario.end_time();
  lane.tolerance = options.tolerance;
  for (int i = 0; i < 2; ++i) turn_[i] = {std::cos(frame_.edges.edge[i].s), std::sin(frame_.edges.edge[i].s)};
  turn_[2] = {std::cos(frame_.rest), std::sin(frame_.rest)};
  reduced_ = frame_.edges.open_at_start && !frame_.circling;
  lane.vx = frame_.velocity.x;
  lane.vy = frame_.velocity.y;
  if (frame_.circling) {
    // Steady sliding: cos d0 = kappa, r = sin d0 (section 2.2 of the paper).
    const double kappa = frame_.kappa_nominal;
    if (kappa == 0) return Need::scalar;
    const double r = kappa < 1 ? std::sqrt((1 - kappa) * (1 + kappa)) : 0;
    lane.vx = r * kappa;
    lane.vy = -r * r;
  }
  next_ = -1;
  return pass_edge();
}

Need EndRun::pass_edge() {
  const Edges<double>& edges = frame_.edges;
  while (true) {
    if (next_ >= 0) {
      const Pair<double> z = take_displacement();
      const Turn& turn = turn_[next_];
      position_ =
          position_ + Pair<double>{z.x * turn.cosine - z.y * turn.sine, z.x * turn.sine + z.y * turn.cosine};
    }
    if (next_ == 2) return Need::done;
    double here = 0;
    if (next_ >= 0) {
      here = edges.edge[static_cast<std::size_t>(next_)].s;
      reduced_ = edges.edge[static_cast<std::size_t>(next_)].opens;
    }
    if (next_ == 0) leave_out_copies();
    const double from = cycle_;
    int following = next_ + 1;
    if (following == 2) {
      following = 0;
      cycle_ += 1;
    }
    const bool to_edge =
        edges.count > 0 &&
        (cycle_ < frame_.cycles ||
         (cycle_ == frame_.cycles && edges.edge[static_cast<std::size_t>(following)].s < frame_.rest));
    const double left =
        to_edge ? (cycle_ - from) * kTwoPi + (edges.edge[static_cast<std::size_t>(following)].s - here)
                : (frame_.cycles - from) * kTwoPi + (frame_.rest - here);
    next_ = to_edge ? following : 2;
    const Need need = set_off(frame_.kappa(reduced_), left);
    if (need != Need::edge) return need;
  }
}

/// Cycles that begin as the last one did, or within rounding, only add its displacement.
void EndRun::leave_out_copies() {
  const Seen before = seen_;
  seen_ = {{lane.vx, lane.vy},
           position_,
           length(Pair<double>{lane.vx, lane.vy} - before.velocity),
           steps,
           before.count + 1};
  if (before.count == 0) return;
  const double copies = frame_.cycles - cycle_ - (frame_.edges.edge[0].s < frame_.rest ? 0 : 1);
  const double ratio = before.count > 1 && before.gap > 0 ? seen_.gap / before.gap : 1;
  const bool settled =
      before.count > 1 && shrinking_.settled(seen_.gap, before.gap, steps - before.steps, at_rest());
  const bool close = copying_error(seen_.gap, ratio, copies) <= 0.2 * lane.tolerance * kTwoPi * frame_.cycles;
  if (copies < 1 || !(settled || close)) return;
  position_ = position_ + copies * (position_ - before.position);
  cycle_ += copies;
}

BatchEnd EndRun::result() const {
  return end_at(frame_.in_metres(position_), end_time_);
}

BatchEnd end_at(const Eigen::Vector2d& position, double time) {
  return {BatchStatus::done, position, direction(position), mean_velocity(position, time)};
}

BatchSteady steady_with(const Eigen::Vector2d& drift, double angular_frequency, double contraction) {
  return {BatchStatus::done, drift, direction(drift), drift.norm() * angular_frequency / kTwoPi, contraction};
}

namespace {

/// Tolerance of the first cycles: what they leave is squared by the next Newton step.
constexpr double kLoosest = 1e-4;
constexpr int kMaxCycles = 40;
/// Newton steps below this leave less than rounding in the velocity, and 1e-13 in the drift.
constexpr double kLastStep = 2e-10;
/// Where no more than this is left the next cycle is to be the last.
constexpr double kNearlyThere = 1e-8;
/// Errors of a cycle add up to 1/(1 - contraction) times as much: too much for lanes beyond this.
constexpr double kHardlyContracts = 0.98;
/// Newton steps shorter than this are sure to lead nearer.
constexpr double kSure = 1e-6;

}  // namespace

Need OrbitRun::begin(const Scenario& scenario, const BatchOptions&) {
  const auto frame = turning_frame(scenario);
  if (!frame) return Need::scalar;
  frame_ = *frame;
  angular_frequency_ = scenario.drive.angular_frequency;
  const double width = scenario.friction.pulse_width;
  const bool low_in_pulse = frame_.kappa_reduced < frame_.kappa_nominal;
  if (frame_.edges.count == 0 || width == kTwoPi || frame_.kappa_reduced == frame_.kappa_nominal)
    return Need::scalar;
  const auto& edges = frame_.edges.edge;
  begin_ = edges[0].opens == low_in_pulse ? edges[0].s : edges[1].s;
  kappa_[0] = std::fmin(frame_.kappa_reduced, frame_.kappa_nominal);
  kappa_[1] = std::fmax(frame_.kappa_reduced, frame_.kappa_nominal);
  span_[0] = low_in_pulse ? width : kTwoPi - width;
  span_[1] = kTwoPi - span_[0];
  if (kappa_[0] >= 1 + 1e-12) return Need::done;  // held throughout
  if (kappa_[1] >= 1) {
    velocity_ = {};  // from a stop, if it comes to one
    lane.tolerance = kLaneTolerance;
  } else {
    // The circle at the mean friction.
    const double mean = (kappa_[0] * span_[0] + kappa_[1] * span_[1]) / kTwoPi;
    const double r = std::sqrt((1 - mean) * (1 + mean));
    velocity_ = {r * mean, -r * r};
    lane.tolerance = kLoosest;
  }
  return begin_cycle();
}

Need OrbitRun::begin_cycle() {
  if (++iterations_ > kMaxCycles) return Need::scalar;
  lane.vx = velocity_.x;
  lane.vy = velocity_.y;
  from_rest_ = at_rest();
  lane.ux[0] = lane.uy[1] = 1;
  lane.ux[1] = lane.uy[0] = 0;
  for (int i = 0; i < 2; ++i) lane.yx[i] = lane.yy[i] = 0;
  drift_ = {};
  return next_segment(0);
}

Need OrbitRun::next_segment(int segment) {
  for (segment_ = segment; segment_ < 2; ++segment_) {
    const Need need = set_off(kappa_[segment_], span_[segment_]);
    if (need != Need::edge) return need;
  }
  return end_cycle();
}

Need OrbitRun::pass_edge() {
  const Pair<double> z = take_displacement();
  if (segment_ == 1) {
    drift_ = drift_ + z;
    return end_cycle();
  }
  const double c = std::cos(span_[0]), s = std::sin(span_[0]);
  drift_ = drift_ + Pair<double>{z.x * c - z.y * s, z.x * s + z.y * c};
  return next_segment(1);
}

/// The motion and its neighbours have come round.
Need OrbitRun::end_cycle() {
  const Pair<double> end{lane.vx, lane.vy}, gap = end - velocity_;
  if (at_rest() && from_rest_) {
    contraction_ = 0;
    return Need::done;  // from stop to stop: nothing is remembered
  }
  if (from_rest_ || at_rest()) {
    velocity_ = end;
    return begin_cycle();
  }
  const Matrix2 jacobian{lane.ux[0], lane.ux[1], lane.uy[0], lane.uy[1]};
  const Matrix2 slope{lane.yx[0], lane.yx[1], lane.yy[0], lane.yy[1]};
  if (lane.tolerance < kLoosest && spectral_radius(jacobian) > kHardlyContracts) return Need::scalar;
  const Pair<double> step = newton_step(jacobian, gap);
  const double size = length(step);
  // Far from the orbit Newton's method can go astray; the map itself never separates two motions.
  if (newton_ && !(size < 0.7 * last_size_)) trusted_ *= 0.3;
  newton_ = size < trusted_ || size < kSure;
  last_size_ = size;
  if (!newton_) {
    velocity_ = end;
    return begin_cycle();
  }
  if (lane.tolerance <= kLaneTolerance && size < kLastStep) {
    drift_ = drift_ + slope * step;
    contraction_ = spectral_radius(jacobian);
    return Need::done;
  }
  velocity_ = velocity_ + step;
  // What the step leaves: terms of second order, and what the Jacobian is off by.
  const double left = size * std::max(size, lane.tolerance > 1e-6 ? 1e-2 : 1e-3);
  lane.tolerance = left < kNearlyThere ? kLaneTolerance : std::clamp(1e-2 * left, kLaneTolerance, kLoosest);
  return begin_cycle();
}

BatchSteady OrbitRun::result() const {
  const double c = std::cos(begin_), s = std::sin(begin_);
  return steady_with(frame_.in_metres({drift_.x * c - drift_.y * s, drift_.x * s + drift_.y * c}),
                     angular_frequency_, contraction_);
}

}  // namespace tribotrack::model::internal
