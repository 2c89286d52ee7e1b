// Rendered recordings in memory and the clock, for the benchmarks.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <vector>

#include "vision/frame_source.h"
#include "vision/io/window.h"
#include "vision/synthesis/noise.h"

namespace tribotrack::vision {

/// CPU time of this thread: what other programs take from the machine does not count.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// White noise, then whole levels of 8 bits.
inline Picture recorded(const Picture& exact, double noise, std::uint64_t frame) {
  const CounterRandom random(20210, frame);
  Picture out = exact;
  std::uint64_t counter = 0;
  for (float& level : out.levels())
    level =
        std::clamp(std::round(level + static_cast<float>(noise) * random.gaussian(counter++)), 0.0F, 255.0F);
  return out;
}

/// Keeps a reference to the frames.
class FramesInMemory : public FrameSource {
 public:
  explicit FramesInMemory(const std::vector<Picture>& frames) : frames_(frames) {
    info_.path = "rendered scene";
    info_.format = "memory";
    info_.width = frames.front().width();
    info_.height = frames.front().height();
    info_.bits = 8;
    info_.frame_count = static_cast<std::int64_t>(frames.size());
    info_.time_base = choose_time_base({user_rate(1000)});
  }
  void read(std::int64_t index, const Rect& window, Picture& picture) override {
    prepare_window(info_, index, window, picture);
    const Picture& frame = frames_[static_cast<std::size_t>(index)];
    for (int y = 0; y < window.height; ++y)
      std::copy_n(frame.row(window.y + y).begin() + window.x, window.width, picture.row(y).begin());
  }

 private:
  const std::vector<Picture>& frames_;
};

}  // namespace tribotrack::vision
