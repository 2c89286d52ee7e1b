// A quieter template: the first frames laid on each other.
//
// The noise of a single template goes into its derivatives, which costs accuracy, and into the residual at
// every fraction of a pixel anew. Averaged over M frames aligned with the first it has 1/M of that variance.
// It is never replaced afterwards: a replaced template drifts.
#pragma once

#include <cstdint>

#include "vision/following/pattern_follower.h"
#include "vision/frame_source.h"
#include "vision/registration/pattern.h"

namespace tribotrack::vision {

inline constexpr int kAveragedFrames = 24;  ///< at most, the first included

struct AveragedTemplate {
  Picture averaged;  ///< the first frame with the template's surroundings averaged; empty for one frame alone
  int frames = 1;    ///< M
  const Picture& picture(const Picture& first) const { return averaged.empty() ? first : averaged; }
};

/// Follows the pattern through the frames after `index` (up to `last`) with the single template and averages
/// what it finds. The part must not turn. One frame alone where fewer than four match.
AveragedTemplate average_template(FrameSource& source, const Picture& first, std::int64_t index,
                                  std::int64_t last, const Pattern& pattern, const FollowOptions& follow);

// Check of the part's texture: does what looks like one in the first frame belong to the part?
//
// A coder leaves marks of its own where it drops the noise, and drops them anew in later frames: they stand
// out of the noise between frames as scratches would, but do not come again with the part.

/// Follows the disc through the frames after `index` (up to `last`), its rotation included, and compares what
/// differs along its rings with the first frame: also with the disc not turned, for a lamp's reflection
/// stands still. False only where it is found and neither is seen again.
bool texture_returns(FrameSource& source, const Picture& first, std::int64_t index, std::int64_t last,
                     const Pattern& disc, const FollowOptions& follow);

}  // namespace tribotrack::vision
