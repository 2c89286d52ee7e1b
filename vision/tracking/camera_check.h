// The camera's noise and bad pixels, from the first frames.
#pragma once

#include <vector>

#include "vision/camera/pixels.h"
#include "vision/stages/frame_range.h"

namespace tribotrack::vision {

inline constexpr int kCameraFrames = 6;  ///< looked at

struct Camera {
  double noise_variance = 0;  ///< grey levels^2
  std::vector<Pixel> bad_pixels;
};

Camera check_camera(FrameSource& source, const FrameRange& range);

}  // namespace tribotrack::vision
