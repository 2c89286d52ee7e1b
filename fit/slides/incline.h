// Where in a track on an incline the part slides, and which way is down.
#pragma once

#include <Eigen/Core>

#include "fit/problem.h"
#include "fit/slides/blows.h"

namespace tribotrack::fit::internal {

/// Of a part that gains speed: from where it is let go to where it is fastest, before it meets whatever ends
/// its way. Of one that loses speed: all that was given, for guess_free_slide() finds its onset.
Stretch sliding_stretch(const TrackTable& track);

/// The direction of the motion, against it where the part was pushed up (slope < 0). A unit vector.
Eigen::Vector2d downhill_of(const TrajectoryRun& run);

}  // namespace tribotrack::fit::internal
