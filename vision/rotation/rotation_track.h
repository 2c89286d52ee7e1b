// The rotation of a disc through a recording, its centre known in every frame, with its standard deviation.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/frame_source.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// A frame in which the disc was found.
struct PlacedFrame {
  std::int64_t index = 0;
  Point centre;
};

/// One per frame, 0 in the first; nothing where the disc's inside does not look like before. Empty where that
/// holds for most frames, or no rotation can be seen.
///
/// The variance is that of the harmonics' scatter, and what grows with the angle turned as the learnt picture
/// is renewed: from how the angles by the inner and the outer rings, each learnt for itself, drift apart. The
/// same for any number of threads.
std::vector<std::optional<Rotation>> follow_rotation(FrameSource& source,
                                                     const std::vector<PlacedFrame>& frames, double radius,
                                                     double blur, int threads = 1);

}  // namespace tribotrack::vision
