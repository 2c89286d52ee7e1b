#include <Eigen/Core>
#include <algorithm>
#include <limits>

#include "model/alpha_v.h"
#include "model/batch/lane_run.h"
#include "model/equation/matrix2.h"

namespace tribotrack::model::internal {
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
  if (!frame) return give_up(ScalarReason::drive);
  frame_ = *frame;
  angular_frequency_ = scenario.drive.angular_frequency;
  const double width = scenario.friction.pulse_width;
  const bool low_in_pulse = frame_.kappa_reduced < frame_.kappa_nominal;
  if (frame_.edges.count == 0 || width == kTwoPi || frame_.kappa_reduced == frame_.kappa_nominal)
    return give_up(ScalarReason::constant_friction);
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
  if (++iterations_ > kMaxCycles) return give_up(ScalarReason::no_convergence);
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
  if (lane.tolerance < kLoosest && spectral_radius(jacobian) > kHardlyContracts)
    return give_up(ScalarReason::weak_friction);
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
  BatchSteady steady;
  steady.status = BatchStatus::done;
  steady.drift = frame_.in_metres({drift_.x * c - drift_.y * s, drift_.x * s + drift_.y * c});
  steady.v = steady.drift.norm() * angular_frequency_ / kTwoPi;
  steady.alpha = steady.v > 0 ? displacement_angle(steady.drift) : std::numeric_limits<double>::quiet_NaN();
  steady.contraction = contraction_;
  return steady;
}

}  // namespace tribotrack::model::internal
