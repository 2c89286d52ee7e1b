// Does light stand in the picture that a frame's own gain and slope cannot follow?
#pragma once

#include <span>

#include "vision/layers/model/disc.h"

namespace tribotrack::vision {

/// Windows whose light over the disc is bent by far more than noise does it, of all: nearly none where the
/// light is what a frame's own gain and slope say.
double curved_light_share(std::span<const KeptWindow> windows, const LayeredDisc& disc,
                          const NoiseLaw& noise);

}  // namespace tribotrack::vision
