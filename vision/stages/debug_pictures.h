// What is shown to TrackOptions::debug: which frames, and in which range of levels.
#pragma once

#include <string>
#include <vector>

#include "vision/tracker.h"

namespace tribotrack::vision {

struct ShownFrame {
  std::int64_t index = 0;  ///< in the source; of status ok
  std::string why;
};

/// In order. `residual` rms of each point of the track, whose first has index `first_index`. None without
/// TrackOptions::debug. Throws InputError where a requested frame was not analysed.
std::vector<ShownFrame> frames_to_show(const Track& track, std::int64_t first_index,
                                       const std::vector<double>& residual, const TrackOptions& options);

/// Both are drawn in the range of the first one's levels.
void share_range(StagePicture& from, StagePicture& with);

/// a - b, NaN where either is.
Picture difference(const Picture& a, const Picture& b);

}  // namespace tribotrack::vision
