#include "vision/io/levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {

void FrameSource::read(std::int64_t index, const Rect& window, Picture& picture) {
  if (index < 0 || index >= info_.frame_count)
    throw std::out_of_range(
        fmt::format("frame {} of '{}', which has {}", index, info_.path.string(), info_.frame_count));
  if (window.width <= 0 || window.height <= 0 || !bounds().contains(window))
    throw std::invalid_argument(
        fmt::format("window {} x {} at ({}, {}) does not lie in the {} x {} picture of '{}'", window.width,
                    window.height, window.x, window.y, info_.width, info_.height, info_.path.string()));
  if (picture.width() != window.width || picture.height() != window.height)
    picture = Picture(window.width, window.height);
  fill(index, window, picture);
}

Rect touched_pixels(double x0, double y0, double x1, double y1, const Rect& bounds) {
  const int left = std::max(bounds.x, static_cast<int>(std::floor(x0)));
  const int top = std::max(bounds.y, static_cast<int>(std::floor(y0)));
  const int right = std::min(bounds.x + bounds.width, static_cast<int>(std::ceil(x1)) + 1);
  const int bottom = std::min(bounds.y + bounds.height, static_cast<int>(std::ceil(y1)) + 1);
  return {left, top, std::max(0, right - left), std::max(0, bottom - top)};
}

Rect window_about(const Point& centre, double reach, const Rect& bounds) {
  return touched_pixels(centre.x - reach, centre.y - reach, centre.x + reach, centre.y + reach, bounds);
}

namespace {

/// In the processor's widest vectors: most of what tracking in an uncompressed recording spends on reading.
TRIBOTRACK_CLONES void copy_bytes(const std::uint8_t* stored, std::span<float> levels) {
  const std::size_t n = levels.size();
  float* to = levels.data();
  for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<float>(stored[i]);
}

template <class Level>
Level level_at(const std::uint8_t* stored, std::ptrdiff_t index = 0) {
  Level level;
  std::memcpy(&level, stored + index * static_cast<std::ptrdiff_t>(sizeof level), sizeof level);
  return level;
}

template <class Level>
void copy_row(const std::uint8_t* stored, const StoredFrame& frame, std::span<float> levels) {
  if (frame.bgr) {
    for (float& level : levels) {
      level = luma(level_at<Level>(stored, 2), level_at<Level>(stored, 1), level_at<Level>(stored));
      stored += frame.pixel;
    }
  } else if (frame.pixel != sizeof(Level)) {
    for (float& level : levels) {
      level = static_cast<float>(level_at<Level>(stored));
      stored += frame.pixel;
    }
  } else if constexpr (sizeof(Level) == 1) {
    copy_bytes(stored, levels);
  } else {
    for (std::size_t x = 0; x < levels.size(); ++x)
      levels[x] = static_cast<float>(level_at<Level>(stored, static_cast<std::ptrdiff_t>(x)));
  }
}

}  // namespace

void copy_stored(const StoredFrame& frame, const Rect& window, Picture& picture) {
  const auto copy = frame.level_bytes == 1   ? copy_row<std::uint8_t>
                    : frame.level_bytes == 2 ? copy_row<std::uint16_t>
                                             : copy_row<float>;
  for (int y = 0; y < window.height; ++y)
    copy(frame.first + (window.y + y) * frame.row + window.x * frame.pixel, frame, picture.row(y));
}

float level_of_share(std::vector<float>& levels, double share) {
  if (levels.empty()) return 0;
  const auto at =
      levels.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(levels.size() - 1));
  std::nth_element(levels.begin(), at, levels.end());
  return *at;
}

void store_levels(std::span<const float> levels, int bits, std::uint8_t* stored) {
  const auto largest = static_cast<float>((1 << bits) - 1);
  for (const float level : levels) {
    const auto whole =
        level > 0 ? static_cast<std::uint16_t>(std::nearbyint(std::min(level, largest))) : std::uint16_t{0};
    *stored++ = static_cast<std::uint8_t>(whole & 0xFF);
    if (bits > 8) *stored++ = static_cast<std::uint8_t>(whole >> 8);
  }
}

}  // namespace tribotrack::vision
