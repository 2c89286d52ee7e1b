// The motion within one exposure as a few weighted poses.
#pragma once

#include <functional>
#include <vector>

#include "vision/scene.h"

namespace tribotrack::vision {

struct ExposureNode {
  double weight = 1;  ///< share of the exposure; they add up to 1
  ScenePose pose;
};

/// Gauss-Legendre nodes over [time - exposure / 2, time + exposure / 2]: one for a scene at rest, else as
/// many as the longest path of disc, rim and platform needs against the smallest blur and the shortest
/// texture wave. Throws std::invalid_argument for a negative exposure and for a pose that is not finite.
std::vector<ExposureNode> exposure_nodes(double time_s, double exposure_s,
                                         const std::function<ScenePose(double)>& pose, double radius_px,
                                         double smallest_blur_px, double largest_wave_number,
                                         double tolerance);

}  // namespace tribotrack::vision
