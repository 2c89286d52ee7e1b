// The platform's motion as curves, for pictures of it.
#pragma once

#include <vector>

#include "fit/measurement.h"

namespace tribotrack::fit {

struct PlatformPicture {
  std::vector<Eigen::Vector2d> orbit;  ///< m, the marker about its mean, one per row of the track
  std::vector<double> phase_left;      ///< rad, by which each frame is ahead of constant w
  std::vector<Eigen::Vector2d> model;  ///< m, one whole turn of the fitted motion
};

/// A frame's phase left is its residual along the direction of motion, over the speed there: eq. (1) to first
/// order. Where the platform stands still for a moment (motion along one axis) it is NaN.
PlatformPicture picture_of(const TrackTable& track, const PlatformMotion& motion);

}  // namespace tribotrack::fit
