// How others follow a disc to a fraction of a pixel: for comparison only (`tribotrack bench vision`).
#pragma once

#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::bench {

/// Follows each target (the part, then the marker) by cv::matchTemplate in a window about its last position,
/// with a parabola between pixels; the template is its square in the first frame. `targets` are given where
/// they lie in the first frame, to the fraction of a pixel. Returns the positions of the first one, px.
std::vector<vision::Point> follow_by_matching(vision::FrameSource& source,
                                              const std::vector<vision::Circle>& targets);

/// Follows each target by a circle through the points of steepest grey level along rays from its last
/// position (Kasa's fit: linear least squares), three times in each frame, the last two without edges that
/// lie beside it.
std::vector<vision::Point> follow_by_circle_fit(vision::FrameSource& source,
                                                const std::vector<vision::Circle>& targets);

}  // namespace tribotrack::bench
