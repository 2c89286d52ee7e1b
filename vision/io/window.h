// What every source does before it fills a window.
#pragma once

#include "vision/frame_source.h"

namespace tribotrack::vision {

/// Checks frame index and window (std::out_of_range, std::invalid_argument: a caller's mistake) and gives the
/// picture the window's size, keeping its memory where it fits.
void prepare_window(const SourceInfo& info, std::int64_t index, const Rect& window, Picture& picture);

/// The whole pixels that x0 .. x1, y0 .. y1 touch, and one beyond at the far ends, inside `bounds`.
Rect touched_pixels(double x0, double y0, double x1, double y1, const Rect& bounds);

/// Those within `reach` px of a centre, either way.
Rect window_about(const Point& centre, double reach, const Rect& bounds);

}  // namespace tribotrack::vision
