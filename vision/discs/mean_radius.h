// The disc's radius from frames spread over the recording, measured in passing.
//
// Where levels are linear in the light the rim's fit holds whatever the blur: a smear by motion widens the
// edge on both sides alike. Colour video is not: it stores about the light's power 1 / 2.2, so the middle of
// a blurred edge, as stored, lies outside its true place on a bright disc (inside on a dark one), by
//   kappa s,  kappa = -Phi^-1((h^2.2 - o^2.2) / (a^2.2 - o^2.2)),  h = (a + o) / 2,
// for stored levels a inside and o outside, and s grows with the speed. Whether a camera does this is not
// known: kappa counts half, with the spread of what lies between none and all of it; frames of different
// speed tell it better.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/discs/disc_detection.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

/// Whether frame n of those shown belongs to the sample: every `stride`-th, and of the first ones some more,
/// for the part may soon leave.
bool in_sample(std::int64_t n, std::int64_t stride);

/// One frame gives the radius with that frame's noise and on that frame's background; the mean over
/// some gives it better, with an sd that keeps what belongs to the disc (mean_radius).
class RimWatch {
 public:
  /// Looks at a sample of the frames it is shown, see in_sample(), the first time from `start`, the rim in
  /// another frame.
  RimWatch(const Circle& disc, std::int64_t stride, std::optional<DiscFit> start = {});

  /// A frame in which the disc was tracked at `centre`. Reads a window of it.
  void see(FrameSource& source, std::int64_t index, Point centre);

  /// Nothing where fewer than two frames showed the rim. Frames in which something covers it are left out: by
  /// their radius, farther from the median than 5 times what the middle half of them suggests. Of colour
  /// video that of the edge without its blur; what is not known of kappa is in sd and common_sd.
  std::optional<MeanRadius> radius() const;

 private:
  Circle disc_;
  std::int64_t stride_;
  std::int64_t seen_ = 0;
  bool curved_levels_ = false;   ///< not linear in the light
  double black_ = 0;             ///< grey level of no light
  std::optional<DiscFit> last_;  ///< where the next fit starts
  std::vector<DiscFit> fits_;
  std::vector<double> speeds_;  ///< in those frames, px per frame
  std::int64_t last_index_ = 0;
  Point last_centre_;
};

}  // namespace tribotrack::vision
