// Pictures of the learnt layers for debugging.
#pragma once

#include "vision/layers/model/ground.h"
#include "vision/layers/model/part.h"
#include "vision/layers/model/state.h"
#include "vision/stages/debug_pictures.h"

namespace tribotrack::vision {

/// Members must outlive this.
struct LearntLayers {
  const PartPictures& part;
  const GroundPicture& ground;
  const Picture& chosen;  ///< 1 where a pixel of the part's grid takes part
};

/// Part, share of the ground, standard deviation that is left, pixels used, ground and its standard
/// deviation.
void show_layers(const LearntLayers& layers, DebugSink& sink);

/// Prediction and residual of a frame in its measured state; reads it again.
void show_layered_frame(const LearntLayers& layers, const LayeredState& state, const ShownFrame& shown,
                        FrameSource& source, DebugSink& sink);

}  // namespace tribotrack::vision
