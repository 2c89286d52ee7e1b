#include <algorithm>
#include <stdexcept>

#include "vision/frame_source.h"
#include "vision/io/window.h"

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

}  // namespace tribotrack::vision
