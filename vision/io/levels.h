// Windows of frames and their grey levels, as sources fill them and sinks store them.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "vision/frame_sink.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

// What every source does before it fills a window.

/// Checks frame index and window (std::out_of_range, std::invalid_argument: a caller's mistake) and gives the
/// picture the window's size, keeping its memory where it fits.
void prepare_window(const SourceInfo& info, std::int64_t index, const Rect& window, Picture& picture);

/// The whole pixels that x0 .. x1, y0 .. y1 touch, and one beyond at the far ends, inside `bounds`.
Rect touched_pixels(double x0, double y0, double x1, double y1, const Rect& bounds);

/// Those within `reach` px of a centre, either way.
Rect window_about(const Point& centre, double reach, const Rect& bounds);

/// A frame as a decoder leaves it: rows `stride` bytes apart, each of levels of 1 or 2 bytes.
struct StoredFrame {
  const std::uint8_t* first = nullptr;
  std::ptrdiff_t stride = 0;
  std::size_t bytes_per_level = 1;
};

/// A recording whose frames are decoded as wholes.
class DecodedSource : public FrameSource {
 public:
  using FrameSource::read;
  void read(std::int64_t index, const Rect& window, Picture& picture) override;
  /// Decodes a frame; nothing where its levels are computed from what is stored. Valid until the next one.
  virtual std::optional<StoredFrame> stored(std::int64_t index) = 0;
  /// Levels of the frame that was decoded last, for which stored() gave nothing; `picture` has the window's
  /// size.
  virtual void compute(const Rect& window, Picture& picture) = 0;
};

/// The rows of a window.
void copy_stored(const StoredFrame& frame, const Rect& window, Picture& picture);

// Stored pixels to grey levels, a row at a time.

/// Luma of ITU-R BT.601 in integers, so that a grey stored in colour comes back exactly.
constexpr float luma(std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  return static_cast<float>((19595.0 * red + 38470.0 * green + 7471.0 * blue) / 65536.0);
}

/// In the processor's widest vectors: most of what tracking in an uncompressed recording spends on reading.
void copy_levels(const std::uint8_t* stored, std::span<float> levels);

/// 16-bit little-endian words at any address.
inline std::uint16_t word_at(const std::uint8_t* stored, std::size_t i) {
  std::uint16_t word;
  std::memcpy(&word, stored + 2 * i, sizeof word);
  return word;
}

inline void copy_levels_16(const std::uint8_t* stored, std::span<float> levels) {
  for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = static_cast<float>(word_at(stored, i));
}

inline void luma_of_bgr(const std::uint8_t* stored, std::span<float> levels) {
  for (std::size_t i = 0; i < levels.size(); ++i)
    levels[i] = luma(stored[3 * i + 2], stored[3 * i + 1], stored[3 * i]);
}

inline void luma_of_bgr_16(const std::uint8_t* stored, std::span<float> levels) {
  for (std::size_t i = 0; i < levels.size(); ++i)
    levels[i] = luma(word_at(stored, 3 * i + 2), word_at(stored, 3 * i + 1), word_at(stored, 3 * i));
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
