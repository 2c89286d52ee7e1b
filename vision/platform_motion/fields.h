// Which parts of the picture the ground is learnt from.
#pragma once

#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// The whole picture, or of a large one the fields of 128 x 128 px with the most information: the smaller
/// eigenvalue of sum grad f grad f^T beyond the noise. What lies over the ground (`hidden`) tells nothing of
/// it, strong as its edges are.
std::vector<Rect> ground_fields(const Picture& first, const std::vector<Circle>& hidden,
                                double noise_variance, int most_pixels);

}  // namespace tribotrack::vision
