// One run solved in a lane: after every step it states which kind of step it needs next.
#pragma once

#include <cmath>

#include "model/batch.h"
#include "model/lanes/turning_frame.h"
#include "model/solver/repetition.h"

namespace tribotrack::model::internal {

enum class Need {
  start,
  slide,
  creep,  ///< one step of that kind
  edge,   ///< it has come to where its friction changes
  done,
  scalar,  ///< it cannot go on in lanes
};
inline constexpr int kStepKinds = 3;

/// What one lane of SlideLanes holds.
struct LaneState {
  double kappa = 0.5, left = 0, tolerance = 1e-13;
  double vx = 1, vy = 0, zx = 0, zy = 0;
  double ux[2] = {}, uy[2] = {}, yx[2] = {}, yy[2] = {};
};

/// The tolerance of each step that leaves drifts good to some 1e-13.
inline constexpr double kLaneTolerance = 1e-14;
/// Below the first speed a step in sigma carries farther; above the second no more.
inline constexpr double kCreepBelow = 0.06, kSlideAbove = 0.09;
/// Below this speed, or this times kappa - 1, the rest of the way to a stop is known in closed form.
inline constexpr double kStopBelow = 1e-5;
/// Starts from rest closer than this to the threshold of friction are stiff.
inline constexpr double kMarginal = 0.02;

/// The results that belong to a displacement, m, over a time, s, and to one per cycle.
BatchEnd end_at(const Eigen::Vector2d& position, double time);
BatchSteady steady_with(const Eigen::Vector2d& drift, double angular_frequency, double contraction);

class LaneRun {
 public:
  LaneState lane;
  int steps = 0;

  /// After a step of that kind.
  Need look(Need kind);

 protected:
  /// On the way over `left` under friction kappa: what first? `edge` if it is there, held at rest or not.
  Need set_off(double kappa, double left);
  bool at_rest() const { return lane.vx == 0 && lane.vy == 0; }
  /// The displacement since the last edge, in the frame that stands as the turning one does at this phase.
  Pair<double> take_displacement() {
    const Pair<double> z{lane.zx, lane.zy};
    lane.zx = lane.zy = 0;
    return z;
  }

 private:
  bool stop();
  int patience_ = 0;
  bool finishing_ = false;  ///< too near the edge for a step in sigma
};

/// To the end of a scenario's run.
class EndRun : public LaneRun {
 public:
  Need begin(const Scenario& scenario, const BatchOptions& options);
  Need pass_edge();
  BatchEnd result() const;

 private:
  struct Turn {
    double cosine = 1, sine = 0;
  };
  void leave_out_copies();

  TurningFrame frame_;
  double end_time_ = 0;
  Turn turn_[3];  ///< of the frame at the edges and at the end
  int next_ = 0;  ///< edge 0, 1, or 2 = the end
  double cycle_ = 0;
  bool reduced_ = false;
  Pair<double> position_;
  /// At the first edge of a cycle.
  struct Seen {
    Pair<double> velocity, position;
    double gap = 0;  ///< of the velocity to that of the cycle before
    int steps = 0, count = 0;
  };
  Seen seen_;
  Shrinking shrinking_{HUGE_VAL};
};

/// To the steady motion: Newton on the one-cycle map from the edge to the lower friction.
class OrbitRun : public LaneRun {
 public:
  Need begin(const Scenario& scenario, const BatchOptions&);
  Need pass_edge();
  BatchSteady result() const;

 private:
  Need begin_cycle();
  Need end_cycle();
  Need next_segment(int segment);

  TurningFrame frame_;
  double angular_frequency_ = 1, begin_ = 0;
  double kappa_[2] = {}, span_[2] = {};
  int segment_ = 0, iterations_ = 0;
  bool from_rest_ = false;
  Pair<double> velocity_, drift_;
  bool newton_ = false;  ///< whether the last step was one
  double trusted_ = 1;   ///< the longest step of Newton's that is believed
  double last_size_ = 0;
  double contraction_ = 0;
};

}  // namespace tribotrack::model::internal
