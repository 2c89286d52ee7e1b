// Does the part's texture show its rotation, and how well?
#pragma once

#include "vision/registration/pattern.h"

namespace tribotrack::vision {

/// Cramer-Rao bound of the rotation alone from one frame, rad: sqrt(noise_variance / sum (dT/dtheta)^2) over
/// the pixels inside the rim; 1e9 where no texture stands out of the noise. `levels` is the pattern's window.
///
/// Noise has slopes of its own, which grow with every pixel while a few scratches do not: slopes are taken
/// of the picture smoothed to a scratch's width. What is much wider than that, a lamp's reflection or
/// shading, holds no information on rotation and is taken out. The bound is that of what is left, so the true
/// one is less.
double rotation_limit(const Picture& levels, const Pattern& pattern, double noise_variance);

}  // namespace tribotrack::vision
