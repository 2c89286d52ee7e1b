// The frames to analyse.
#pragma once

#include <cstdint>

#include "vision/tracker.h"

namespace tribotrack::vision {

struct FrameRange {
  std::int64_t first = 0, last = 0;  ///< indices, both included
  std::int64_t count() const { return last - first + 1; }
};

/// From the recording's own numbers. Throws InputError where it does not hold them.
FrameRange frames_to_analyse(const FrameSource& source, const TrackOptions& options);

}  // namespace tribotrack::vision
