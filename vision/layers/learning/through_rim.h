// What the disc's rim lets through of the platform.
//
// A disc that hardly moves against the platform never uncovers the places under its own rim, yet they are
// seen through it. With S, w and the positions known, a pixel of the rim says
//   B(x - p) = [I(x) - a (1 + g . u) S(u)] / (b w(u))   with the noise's variance over (b w)^2.
#pragma once

#include <span>

#include "vision/layers/model/disc.h"
#include "vision/layers/model/ground.h"

namespace tribotrack::vision {

/// Replaces what the ground has learnt through the rim by what these windows show in their present states,
/// and finishes it again.
void look_through_rim(std::span<const KeptWindow> windows, const LayeredDisc& disc, double noise_variance,
                      GroundPicture& ground);

}  // namespace tribotrack::vision
