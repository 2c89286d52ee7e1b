// By how many pixels has the ground moved since the first frame? A start for its registration.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Cross-correlation of whole pictures by Fourier transform, both under a Hann window, what is hidden and
/// what is broad (light) taken off. Large pictures are binned.
class CoarseShift {
 public:
  CoarseShift(const Picture& first, const std::vector<Circle>& hidden);
  /// To within half a bin where the ground shows a texture.
  Point of(const Picture& picture, const std::vector<Circle>& hidden) const;
  int bin() const { return bin_; }

 private:
  cv::Mat spectrum(const Picture& picture, const std::vector<Circle>& hidden) const;
  int bin_ = 1;
  cv::Mat hann_, first_;
};

}  // namespace tribotrack::vision
