// What a coder did to the rim of a disc and to a mark, frame by frame, and how far they can move before it
// notices.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/frame_source.h"
#include "vision/picture.h"

namespace tribotrack::vision {

// How a coder stored the rim of a disc in one frame.
//
// A displacement along x is told by the edges across it, so a place of the rim at the angle phi counts by
// cos^2 phi for x and by sin^2 phi for y.

struct RimCoding {
  char type = '?';        ///< of the frame
  double step = 0;        ///< of the quantiser at the rim, grey levels; 0 unknown
  Point still = {0, 0};   ///< share that is predicted from the same place of another frame, for x and y
  Point moving = {0, 0};  ///< share that is predicted from elsewhere
};

RimCoding rim_coding(const CodedFrame& frame, const Circle& rim);

// What the coder did to the part and to the platform's mark, frame by frame, gathered while the recording is
// decoded for the first time.

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

// How far a part can move before its coder notices.
//
// Where another frame predicts a block, what the prediction leaves is transformed, and coefficients below
// z steps of the quantiser are dropped (z: Coder::dead_zone). A displacement d along x leaves d dI/dx. So
// nothing of it is coded up to
//   d0 = z step / m,   m = max_k |DCT(dI/dx)_k|,
// with the mean of m over the blocks about the rim, weighed by their information (dI/dx)^2: the blocks that
// tell most of a displacement are the first to notice it. For a straight edge of contrast c along the grid,
// blurred by less than half a block, the largest coefficient of its slope is sqrt(2) c in blocks of 4 x 4 and
// 8 x 8 alike: d0 = 0.59 step / c for x264.

/// px that a part can move along x and y unnoticed, for a dead zone of one grey level. Of what lies within
/// `margin` px of the circle's line; negative: all of the circle's inside as well. 0 where nothing shows.
Point unnoticed_motion(const Picture& picture, const Circle& rim, double margin);

}  // namespace tribotrack::vision
