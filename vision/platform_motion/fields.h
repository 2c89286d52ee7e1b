// Which parts of the picture the ground is learnt from.
#pragma once

#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// The whole picture, or of a large one the fields of 128 x 128 px with the most information: the smaller
/// eigenvalue of sum grad f grad f^T beyond the noise.
std::vector<Rect> ground_fields(const Picture& first, double noise_variance, int most_pixels);

}  // namespace tribotrack::vision
