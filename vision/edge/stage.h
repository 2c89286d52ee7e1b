// The edge in bands of time as a stage of tracking: whether it pays, and whether it does better than
// pictures.
#pragma once

#include <string>
#include <vector>

#include "vision/edge/edge.h"
#include "vision/stages/first_pass_result.h"
#include "vision/stages/stage_clock.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

struct EdgeOutcome {
  bool done = false;  ///< else the track is as it was, and only the plan is filled
  std::vector<PlanStage> plan;
  double limit_px = 0;                ///< median standard deviation of a coordinate
  double slow_sd = 0, slow_time = 0;  ///< see TrackSummary
};

/// `stated` is the error of a coordinate, px, that the track and its audit state.
/// Measures the ok points of `track` again by the part's edge where noise alone would allow clearly less than
/// the track says of itself: something turns, or the light changes. Positions and covariances change where
/// the edge is better known than the track: where the two differ by more than the edge's own errors, the
/// track's are at least what is left, of a part that turns all of it.
EdgeOutcome edge_stage(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                       StageClock& clock, double stated, Track& track);

}  // namespace tribotrack::vision
