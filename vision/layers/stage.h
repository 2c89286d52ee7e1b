// The layered second pass as a stage of tracking: whether it pays, and what it changes in a track.
#pragma once

#include <string>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/camera/frame_cache.h"
#include "vision/stages/debug_pictures.h"
#include "vision/stages/first_pass_result.h"
#include "vision/stages/stage_clock.h"

namespace tribotrack::vision {

/// What the stage found out, for the track's summary.
struct LayeredOutcome {
  bool ground_known = true;  ///< else what the rim borders on changes from frame to frame
  bool done = false;         ///< else the track is as it was, and only the plan is filled
  std::vector<PlanStage> plan;
  std::vector<std::string> warnings;
  double limit_px = 0;                         ///< median standard deviation of a coordinate
  double slow_sd = 0, slow_time = 0;           ///< see TrackSummary
  std::vector<AuditFrame> audited;             ///< frames whose halves were compared
  double disc_radius = 0, disc_radius_sd = 0;  ///< px; 0 where the averaged picture shows no circle
};

/// Measures every frame again over the platform's own picture where that pays: positions, standard deviations
/// and correlations of the track's ok points change, never their status. `shown` frames go to
/// TrackOptions::debug.
LayeredOutcome layered_stage(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                             const std::vector<ShownFrame>& shown, StageClock& clock, Track& track);

/// Whether layered_stage() would try, as far as this is known: before the first pass its residuals are not.
bool layers_wanted(const FirstPassResult& first, Layers layers);

/// Caches what the second pass, and the rotation by rings, will read again while the first has it decoded: of
/// every frame in which the part is seen a window about it, and whole those that the layers are probably
/// learnt from. Nothing for recordings that are not decoded.
class FramesReadAgain {
 public:
  FramesReadAgain(KeptFrames& frames, const FirstPassResult& first, Layers layers);
  void seen(std::int64_t index, const Point& centre);

 private:
  KeptFrames& frames_;
  std::int64_t first_index_, total_;
  bool layers_;
  double reach_;
};

}  // namespace tribotrack::vision
