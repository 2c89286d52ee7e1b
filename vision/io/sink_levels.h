// What every sink does with a picture before it stores it.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "vision/frame_sink.h"

namespace tribotrack::vision {

/// Whole level 0 .. largest; not a number gives 0.
inline std::uint16_t whole_level(float level, float largest) {
  if (!(level > 0)) return 0;
  return static_cast<std::uint16_t>(std::nearbyint(level < largest ? level : largest));
}

inline float largest_level(int bits) {
  return static_cast<float>((1 << bits) - 1);
}

/// Throws std::invalid_argument where the size is not the sink's (a caller's mistake).
void require_size(const SinkOptions& options, int width, int height);

}  // namespace tribotrack::vision
