// What the second pass is given: the frames as the first pass left them.
#pragma once

#include <cstdint>

#include "vision/picture.h"

namespace tribotrack::vision {

/// A frame as the first pass left it.
struct FirstPassFrame {
  std::int64_t index = 0;
  Point centre;
  Point ground;  ///< the platform's displacement since the first frame
};

/// Frames spread over a recording that the layers are learnt from, as far as the part is seen in them. The
/// layers' own noise adds 1 / kLearningFrames to the variance.
inline constexpr std::int64_t kLearningFrames = 128;
/// Whether the frame at this place (0 .. total - 1) of those analysed is one of them.
bool is_learning_frame(std::int64_t place, std::int64_t total);
/// Half width of the part's grid, px: the part with its rim and its shadow.
int layered_half(double radius, double blur);
/// Px about the part's centre that are looked at in every frame.
double layered_reach(double radius, double blur);

}  // namespace tribotrack::vision
