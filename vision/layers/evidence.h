// How quiet a track is, by itself: what candidates are chosen by.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

struct TimedPoint {
  std::int64_t frame = 0;
  Point place;
};

/// Standard deviation of a coordinate from frame to frame, px: from third differences of consecutive frames,
/// whose variance for white noise is 20 times that of a position; the median of their squares, so that a
/// collision does not count. Motion that three differences leave over adds to it alike for every candidate of
/// the same recording. Infinite without four consecutive frames.
double frame_noise(const std::vector<TimedPoint>& track);

}  // namespace tribotrack::vision
