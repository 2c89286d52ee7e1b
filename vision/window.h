// What every source does before it fills a window.
#pragma once

#include "vision/frame_source.h"

namespace tribotrack::vision {

/// Checks frame index and window (std::out_of_range, std::invalid_argument: a caller's mistake) and gives the
/// picture the window's size, keeping its memory where it fits.
void prepare_window(const SourceInfo& info, std::int64_t index, const Rect& window, Picture& picture);

}  // namespace tribotrack::vision
