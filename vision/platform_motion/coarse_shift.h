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

// A mean picture freed of the noise that is left in it.

/// What is broad (light) by a mean over kBroad px; the rest by Wiener's filter: every spatial frequency is
/// kept by the share of its power that is not the noise's, the power a mean over neighbouring frequencies. A
/// brushed ground lies on few frequencies, so most of the noise goes; slopes of what is left are slopes of
/// the ground. What is not `known` (0) is filled from what is, again and again (Papoulis, IEEE Trans.
/// Circuits Syst. 22, 1975): a step there would look like a texture. `noise_variance` of a pixel, grey
/// levels^2.
/// `before`: a like picture, to fill from at first.
Picture noise_free(const Picture& picture, const Picture& known, double noise_variance,
                   const Picture* before = nullptr);

}  // namespace tribotrack::vision
