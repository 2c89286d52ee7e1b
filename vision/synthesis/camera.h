// What acts on whole pixels of a synthetic scene: vignetting, flickering light, noise and the depth of the
// levels.
#pragma once

#include <cstdint>

#include "vision/picture.h"
#include "vision/scene.h"

namespace tribotrack::vision {

class SceneCamera {
 public:
  explicit SceneCamera(const Scene& scene);

  /// Mean of 1 + f sin(2 pi h t) over [time - exposure / 2, time + exposure / 2].
  double flicker(double time_s, double exposure_s) const;
  /// From light on the 8-bit scale to exact levels: 1 - vignetting (r / r_corner)^2, times 2^(bits - 8).
  void to_levels(Picture& picture) const;
  /// From exact to recorded levels: Gaussian noise of variance read^2 + shot I from seed and index alone,
  /// rounding, clipping to 0 .. 2^bits - 1.
  void record(Picture& picture, std::int64_t index) const;

 private:
  double flicker_ = 0, flicker_hz_ = 0;
  float read_variance_ = 0;       // at the recording's own depth
  float variance_per_level_ = 0;  // likewise
  float top_level_ = 255;
  std::uint64_t seed_ = 0;
  Picture gain_;
};

}  // namespace tribotrack::vision
