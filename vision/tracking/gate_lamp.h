// How bright a lamp in the picture is: direct evidence of the gate signal in the recording.
#pragma once

#include <cstdint>

#include "vision/frame_source.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// Mean grey level of the pixels whose centres lie in a circle, frame by frame. The lamp does not move, so
/// every pixel of the circle sees a fixed share of it and the mean is linear in the light: lit for a share s
/// of an exposure it lies at off + s (on - off), whatever the circle's fit to the lamp. Only pixels that clip
/// break this; they are counted.
class GateLamp {
 public:
  /// Throws InputError where the circle is not wholly in the picture.
  GateLamp(const Circle& circle, const FrameSource& source);

  struct Sample {
    double level = 0;          ///< grey levels
    double clipped_share = 0;  ///< share of the pixels at the top level
  };
  Sample sample(FrameSource& source, std::int64_t index);

  int pixels() const { return pixels_; }

 private:
  Circle circle_;
  Rect window_;
  float top_;
  int pixels_ = 0;
  Picture picture_;  ///< work space
};

}  // namespace tribotrack::vision
