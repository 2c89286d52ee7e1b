#include <algorithm>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "vision/frame_source.h"
#include "vision/io/levels.h"

namespace tribotrack::vision {

MemorySource::MemorySource(std::vector<Picture> frames, double frame_rate_hz, int bits)
    : frames_(std::move(frames)) {
  if (frames_.empty()) throw std::invalid_argument("a recording in memory needs at least one picture");
  if (!(frame_rate_hz > 0)) throw std::invalid_argument("the frame rate must be above 0 Hz");
  const Picture& first = frames_.front();
  for (const Picture& frame : frames_)
    if (frame.width() != first.width() || frame.height() != first.height())
      throw std::invalid_argument("the pictures of a recording must have one size");
  info_.path = "pictures in memory";
  info_.format = "memory";
  info_.codec = "uncompressed";
  info_.width = first.width();
  info_.height = first.height();
  info_.bits = bits;
  info_.frame_count = static_cast<std::int64_t>(frames_.size());
  info_.time_base = choose_time_base({user_rate(frame_rate_hz)});
}

void MemorySource::read(std::int64_t index, const Rect& window, Picture& picture) {
  prepare_window(info_, index, window, picture);
  const Picture& frame = frames_[static_cast<std::size_t>(index)];
  for (int y = 0; y < window.height; ++y)
    std::copy_n(frame.row(window.y + y).begin() + window.x, window.width, picture.row(y).begin());
}

namespace {

/// `stride` is a constant of the type where rows are contiguous: that loop is vectorised.
template <typename Level, typename Stride>
void copy_row(const std::byte* stored, Stride stride, std::span<float> row) {
  for (float& level : row) {
    Level value;
    std::memcpy(&value, stored, sizeof value);
    level = static_cast<float>(value);
    stored += stride;
  }
}

template <typename Level>
void copy_rows(const std::byte* stored, const FrameStack& stack, Picture& picture) {
  const std::integral_constant<std::ptrdiff_t, sizeof(Level)> contiguous;
  for (int y = 0; y < picture.height(); ++y, stored += stack.row_stride) {
    if (stack.level_stride == contiguous)
      copy_row<Level>(stored, contiguous, picture.row(y));
    else
      copy_row<Level>(stored, stack.level_stride, picture.row(y));
  }
}

}  // namespace

StackSource::StackSource(const FrameStack& stack, double frame_rate_hz, int bits) : stack_(stack) {
  if (stack.frames < 1 || stack.width < 1 || stack.height < 1)
    throw std::invalid_argument("a recording in memory needs at least one picture of one pixel");
  if (stack.bytes_per_level != 1 && stack.bytes_per_level != 2)
    throw std::invalid_argument("grey levels in memory must have 1 or 2 bytes");
  if (bits < 1 || bits > 8 * stack.bytes_per_level)
    throw std::invalid_argument("levels of " + std::to_string(stack.bytes_per_level) + " bytes have 1 to " +
                                std::to_string(8 * stack.bytes_per_level) + " bits, not " +
                                std::to_string(bits));
  if (!(frame_rate_hz > 0)) throw std::invalid_argument("the frame rate must be above 0 Hz");
  info_.path = "frames in memory";
  info_.format = "memory";
  info_.codec = "uncompressed " + std::to_string(bits) + " bit";
  info_.width = stack.width;
  info_.height = stack.height;
  info_.bits = bits;
  info_.frame_count = stack.frames;
  info_.time_base = choose_time_base({user_rate(frame_rate_hz)});
}

void StackSource::read(std::int64_t index, const Rect& window, Picture& picture) {
  prepare_window(info_, index, window, picture);
  const auto* first = static_cast<const std::byte*>(stack_.first) + index * stack_.frame_stride +
                      window.y * stack_.row_stride + window.x * stack_.level_stride;
  if (stack_.bytes_per_level == 1)
    copy_rows<std::uint8_t>(first, stack_, picture);
  else
    copy_rows<std::uint16_t>(first, stack_, picture);
}

}  // namespace tribotrack::vision
