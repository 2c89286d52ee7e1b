#include "vision/tracking/camera_check.h"

#include <algorithm>
#include <array>

#include "vision/camera/pixels.h"

namespace tribotrack::vision {

// Whole pictures are large: never more than three at a time.
Camera check_camera(FrameSource& source, const FrameRange& range) {
  const std::int64_t last = std::min(range.last, range.first + kCameraFrames - 1);
  const Picture first = source.read(range.first);
  const Picture* before = &first;
  std::array<Picture, 2> others;
  NoiseEstimate estimate;
  for (std::int64_t k = range.first + 1; k <= last; ++k) {
    Picture& now = others[static_cast<std::size_t>(k % 2)];
    source.read(k, source.bounds(), now);
    estimate.add_pair(*before, now);
    before = &now;
  }
  Camera camera{estimate.variance(first), {}};
  BadPixelSearch search(first, camera.noise_variance);
  for (std::int64_t k = range.first + 1; k <= last && !search.settled(); ++k) {
    source.read(k, source.bounds(), others[0]);
    search.look(others[0]);
  }
  camera.bad_pixels = search.found();
  return camera;
}

}  // namespace tribotrack::vision
