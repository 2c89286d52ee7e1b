// Pictures of the learnt layers for debugging.
#pragma once

#include "vision/layers/model/disc.h"
#include "vision/layers/model/ground.h"
#include "vision/layers/model/state.h"
#include "vision/stages/debug_pictures.h"

namespace tribotrack::vision {

/// Members must outlive this.
struct LearntLayers {
  const LayeredDisc& disc;
  const GroundPicture& ground;
  const Picture& weights;                  ///< 1 where a pixel of the disc's grid is used one by one
  const StaticIllumination* illumination;  ///< null where none was learnt
};

/// Disc, background and its standard deviation, rim profile, weights, static illumination.
void show_layers(const LearntLayers& layers, DebugSink& sink);

/// Prediction and residual of a frame in its measured state; reads it again.
void show_layered_frame(const LearntLayers& layers, const LayeredState& state, const ShownFrame& shown,
                        FrameSource& source, DebugSink& sink);

}  // namespace tribotrack::vision
