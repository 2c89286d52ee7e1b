#include <limits>

#include "model/alpha_v.h"
#include "model/batch/lane_run.h"

namespace tribotrack::model::internal {

Need EndRun::begin(const Scenario& scenario, const BatchOptions& options) {
  if (scenario.start == Start::steady) return give_up(ScalarReason::start);
  const auto frame = turning_frame(scenario);
  if (!frame) return give_up(ScalarReason::drive);
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
    if (kappa == 0) return give_up(ScalarReason::start);
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
  BatchEnd end;
  end.status = BatchStatus::done;
  end.position = frame_.in_metres(position_);
  end.v = mean_velocity(end.position, end_time_);
  end.alpha =
      end.position.norm() > 0 ? displacement_angle(end.position) : std::numeric_limits<double>::quiet_NaN();
  return end;
}

}  // namespace tribotrack::model::internal
