// The disc's radius from frames spread over the recording, measured in passing.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/discs/disc_detection.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

/// One frame gives the radius with that frame's noise and on that frame's background; the mean over
/// some gives it better, with an sd that keeps what belongs to the disc (mean_radius).
class RimWatch {
 public:
  /// Looks at every `stride`-th frame it is shown, the first time from `start`, the rim in another frame.
  RimWatch(const Circle& disc, std::int64_t stride, std::optional<DiscFit> start = {});

  /// A frame in which the disc was tracked at `centre`. Reads a window of it.
  void see(FrameSource& source, std::int64_t index, Point centre);

  /// Nothing where fewer than two frames showed the rim. Frames in which something covers it are left out: by
  /// their radius, farther from the median than 5 times what the middle half of them suggests.
  std::optional<MeanRadius> radius() const;

 private:
  Circle disc_;
  std::int64_t stride_;
  std::int64_t seen_ = 0;
  std::optional<DiscFit> last_;  ///< where the next fit starts
  std::vector<DiscFit> fits_;
};

}  // namespace tribotrack::vision
