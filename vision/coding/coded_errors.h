// What a lossy coder adds to the errors of a track that its own pictures do not show.
//
// The scatter of clusters and halves (vision/layers/registration/scatter.h, vision/audit) finds what blocks
// do to the position each by itself. What all blocks of the rim do together it cannot see: where a block is
// predicted from another frame and the displacement since is not worth coding (dead_zone.h), the part stays
// behind. It then follows its motion like a play of half width d0: behind by up to d0, in the direction of
// the motion. Over a run of such frames the error is taken as even in (-d0, d0):
//   var = share d0^2 / 3
// along each axis, share of the rim's information in blocks predicted from the same place; half that for
// blocks predicted from elsewhere, whose vector follows the part to a quarter of a pixel. By frame.
#pragma once

#include <vector>

#include "vision/coding/coding_watch.h"
#include "vision/picture.h"
#include "vision/track.h"

namespace tribotrack::vision {

inline constexpr double kMovingShare = 0.5;

/// Widens the covariances of ok points. `first_index`: of the track's first point. `unnoticed`: of the part,
/// for a dead zone of one grey level.
void widen_for_coding(const Coder& coder, const std::vector<WatchedFrame>& frames, std::int64_t first_index,
                      const Point& unnoticed, Track& track, CodedErrors& found);

}  // namespace tribotrack::vision
