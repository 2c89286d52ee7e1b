// Millimetres per pixel.
#pragma once

#include "vision/track.h"

namespace tribotrack::vision {

/// From the part's true diameter D and its radius R in the picture. The sd holds that of the radius and what
/// nobody knows of the rim: an edge of blur s shows its half height at R - s^2/(2 R) where the optics blur a
/// sharp disc, and at R where the disc's own edge is soft. Half of that is taken as the sd of the radius
/// besides its noise:
///   sd(R)^2 = radius_sd^2 + (s^2/(4 R))^2.
Scale scale_from_diameter(double diameter_mm, double radius_px, double radius_sd_px, double blur_px);

/// As the user gave it; no sd of its own.
Scale given_scale(double mm_per_px);

}  // namespace tribotrack::vision
