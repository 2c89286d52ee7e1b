// Every frame measured over the pictures learnt.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/frame_source.h"
#include "vision/layers/first_pass.h"
#include "vision/layers/learning.h"
#include "vision/layers/registration/registration.h"
#include "vision/stages/debug_pictures.h"

namespace tribotrack::vision {

struct MeasuredFrames {
  /// One per frame, nullopt where the model does not hold (too near the border, something in the way). Their
  /// covariances are what the residuals support, see scatter.h.
  std::vector<std::optional<LayeredFix>> fixes;
  /// Errors that neighbouring frames share, in the covariances: standard deviation of a coordinate, px, and
  /// over how many frames they stay alike.
  double slow_sd = 0, slow_frames = 0;
  std::vector<AuditFrame> audited;  ///< of some of the frames, their halves compared
};

/// `registration` holds the pictures learnt. `progress` may be empty.
MeasuredFrames measure_frames(FrameSource& source, const std::vector<FirstPassFrame>& frames,
                              const LayeredRegistration& registration, const LearntPart& learnt, int threads,
                              const std::function<void(std::int64_t done)>& progress);

// Pictures of the learnt layers for debugging.

/// Part, share of the ground, standard deviation that is left, ground and its
/// standard deviation.
void show_layers(const PartPictures& part, const GroundPicture& ground, DebugSink& sink);

/// Prediction and residual of a frame in its measured state; reads it again.
void show_layered_frame(const PartPictures& part, const GroundPicture& ground, const LayeredState& state,
                        const ShownFrame& shown, FrameSource& source, DebugSink& sink);

}  // namespace tribotrack::vision
