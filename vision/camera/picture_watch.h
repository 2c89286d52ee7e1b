// Tracking by the pictures that a recording shows, each of them once.
#pragma once

#include <functional>

#include "vision/frame_source.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

/// Tracks every n-th frame, as the options say, by `run`; again without the pictures that repeat others, if
/// the first run meets such: these become points of status `repeat`. Throws InputError for weaved fields.
TrackResult track_each_picture_once(
    FrameSource& recording, const TrackOptions& options,
    const std::function<TrackResult(FrameSource& source, const TrackOptions& options)>& run);

}  // namespace tribotrack::vision
