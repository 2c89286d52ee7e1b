// The layered second pass as a stage of tracking: whether it is worth while, and what it changes in a track.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "vision/frame_source.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

/// What the first pass leaves behind.
struct FirstPass {
  std::int64_t first_index = 0;  ///< of the track's first point in the source
  std::int64_t total = 0;        ///< frames analysed
  std::vector<double> theta;     ///< the part's rotation, one per point
  bool turning = false;          ///< its texture shows its rotation
  double noise_variance = 0;
  double ground_texture = 0;  ///< about the part in the first frame, grey levels rms beyond the noise
  double excess = 0;          ///< median residual beyond the noise, grey levels rms
  double blur = 0;            ///< of the part's rim, px; 0 where the part is not a disc
  double layers_cost = 0;     ///< see plan_costs.h
};

/// Measures every frame again over the platform's own picture where the plan says that it pays: positions,
/// standard deviations and correlations of the track's ok points change, never their status. Says in
/// summary.plan why or why not. Returns whether it was done. `progress(done)` is called with the number of
/// frames done.
bool layered_stage(FrameSource& source, const FirstPass& first, Layers layers, Track& track,
                   TrackSummary& summary, const std::function<void(std::int64_t)>& progress);

/// Whether layered_stage() would try, as far as this is known after the first pass; radius of the part, px.
bool layers_wanted(const FirstPass& first, double radius, Layers layers);

}  // namespace tribotrack::vision
