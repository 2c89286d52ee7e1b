// What the coder did to the part and to the platform's mark, frame by frame, gathered while the recording is
// decoded for the first time.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/coding/rim_coding.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

struct WatchedFrame {
  std::int64_t index = 0;  ///< in the source
  RimCoding part;
  RimCoding mark;  ///< the round mark, or all of the picture where the ground serves as one
};

/// Nothing is gathered from recordings that no lossy coder made.
class CodingWatch {
 public:
  /// `recording` is the one that decodes, not what caches it. Keeps the reference.
  CodingWatch(const FrameSource& recording, double part_radius)
      : recording_(recording), radius_(part_radius) {}
  /// The part's centre, and the round mark where one was seen. The frame was read just now.
  void see(std::int64_t index, const Point& centre, const std::optional<Circle>& mark);
  const std::vector<WatchedFrame>& frames() const { return frames_; }

 private:
  const FrameSource& recording_;
  double radius_;
  std::vector<WatchedFrame> frames_;
};

}  // namespace tribotrack::vision
