// By how many pixels has the ground moved since the first frame? A start for its registration.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Cross-correlation of whole pictures by Fourier transform, the first one under a Hann window and freed of
/// its noise, of which a brushed ground would be located by little else along its brush. What is hidden, what
/// is broad (light) and what stands out too far (things that cross) is taken off. Large pictures are binned.
class CoarseShift {
 public:
  CoarseShift(const Picture& first, const std::vector<Circle>& hidden, double noise_variance);
  /// To within half a bin where the ground shows a texture.
  Point of(const Picture& picture, const std::vector<Circle>& hidden) const;
  int bin() const { return bin_; }

 private:
  cv::Mat texture(const Picture& picture, const std::vector<Circle>& hidden) const;
  int bin_ = 1;
  cv::Mat first_;  ///< spectrum
};

}  // namespace tribotrack::vision
