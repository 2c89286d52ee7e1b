// Check of the part's texture: does what looks like one in the first frame belong to the part?
//
// A coder leaves marks of its own where it drops the noise, and drops them anew in later frames: they stand
// out of the noise between frames as scratches would, but do not come again with the part.
#pragma once

#include <cstdint>

#include "vision/following/pattern_follower.h"
#include "vision/frame_source.h"
#include "vision/registration/pattern.h"

namespace tribotrack::vision {

/// Follows the disc through the frames after `index` (up to `last`), its rotation included, and compares what
/// differs along its rings with the first frame: also with the disc not turned, for a lamp's reflection
/// stands still. False only where it is found and neither is seen again.
bool texture_returns(FrameSource& source, const Picture& first, std::int64_t index, std::int64_t last,
                     const Pattern& disc, const FollowOptions& follow);

}  // namespace tribotrack::vision
