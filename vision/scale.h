// Millimetres per pixel.
#pragma once

#include "vision/track.h"

namespace tribotrack::vision {

/// From the part's true diameter and its radius in the picture; sd from that of the radius.
Scale scale_from_diameter(double diameter_mm, double radius_px, double radius_sd_px);

/// As the user gave it; no sd of its own.
Scale given_scale(double mm_per_px);

}  // namespace tribotrack::vision
