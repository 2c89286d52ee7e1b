// Windows of frames and their grey levels, as sources fill them and sinks store them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vision/frame_sink.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

/// The whole pixels that x0 .. x1, y0 .. y1 touch, and one beyond at the far ends, inside `bounds`.
Rect touched_pixels(double x0, double y0, double x1, double y1, const Rect& bounds);

/// Those within `reach` px of a centre, either way.
Rect window_about(const Point& centre, double reach, const Rect& bounds);

/// A frame in memory: pixel (x, y) at first + y row + x pixel, strides in bytes that may be negative.
struct StoredFrame {
  const std::uint8_t* first = nullptr;
  std::ptrdiff_t row = 0, pixel = 1;
  int level_bytes = 1;  ///< 1, 2 (the lower first), or 4: a float
  bool bgr = false;     ///< three levels to a pixel, of which luma is made
};

/// The levels of a window, whose size `picture` has.
void copy_stored(const StoredFrame& frame, const Rect& window, Picture& picture);

inline StoredFrame stored_in(const Picture& picture) {
  return {reinterpret_cast<const std::uint8_t*>(picture.levels().data()),
          static_cast<std::ptrdiff_t>(sizeof(float)) * picture.width(), sizeof(float), sizeof(float)};
}

/// Luma of ITU-R BT.601 in integers, so that a grey stored in colour comes back exactly.
constexpr float luma(double red, double green, double blue) {
  return static_cast<float>((19595.0 * red + 38470.0 * green + 7471.0 * blue) / 65536.0);
}

/// The level below which that share of them lies, 0 to 1; of none 0. Reorders them.
float level_of_share(std::vector<float>& levels, double share);

// What every sink does with a picture before it stores it.

/// Whole levels 0 .. 2^bits - 1, a byte each, or two where `bits` is above 8 (the lower first); not a number
/// gives 0.
void store_levels(std::span<const float> levels, int bits, std::uint8_t* stored);

/// Throws std::invalid_argument where the size is not the sink's (a caller's mistake).
void require_size(const SinkOptions& options, int width, int height);

}  // namespace tribotrack::vision
