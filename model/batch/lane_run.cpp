#include "model/batch/lane_run.h"

namespace tribotrack::model::internal {

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
  if (kappa > 1 - kMarginal) return give_up(ScalarReason::marginal);
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
  if (--patience_ < 0) return give_up(ScalarReason::many_steps);
  const double square = lane.vx * lane.vx + lane.vy * lane.vy;
  if (!(square < 1e8)) return give_up(ScalarReason::many_steps);
  if (kind == Need::creep) {
    if (square > kSlideAbove * kSlideAbove) return Need::slide;
    const double slow = kStopBelow * std::fmin(1, lane.kappa - 1);
    if (slow > 0 && square < slow * slow) return stop() ? Need::edge : give_up(ScalarReason::marginal);
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

}  // namespace tribotrack::model::internal
