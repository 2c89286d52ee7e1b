// Blows and collisions in the track of a free slide.
//
// Friction brakes: within a time T it changes the velocity by no more than a T, a its deceleration. A blow
// changes it between two frames. At every place of the track a parabola is laid through the w points before
// and one through the w points after; where their velocities differ by more than friction does over w points
// and by more than noise does by chance anywhere in the track, the part was struck.
//
// Not found: a push that lasts longer than w points, and a touch that changes the velocity by less than
// friction does meanwhile.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "fit/track_table.h"

namespace tribotrack::fit::internal {

struct FoundBlow {
  std::size_t row = 0;  ///< the first point after it
  Eigen::Vector2d before = Eigen::Vector2d::Zero(), after = Eigen::Vector2d::Zero();  ///< velocities, m/s
};

/// In the order of time.
std::vector<FoundBlow> find_blows(const TrackTable& track);

/// Points [first, last) without a blow.
struct Stretch {
  std::size_t first = 0, last = 0;
};

/// The one in which the part slides longest; the points beside a blow, whose exposure it may have met, are
/// left out. The whole track without blows.
Stretch longest_clean_stretch(const TrackTable& track, const std::vector<FoundBlow>& blows);

}  // namespace tribotrack::fit::internal
