// Blows and collisions in the track of a free slide, and the rate at which the part turns.
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

#include "fit/problem.h"

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

/// At the slide's first point, by least squares of the angles seen on the law's
///   theta(t) = theta_0 + turned(t; omega, b),
/// with theta_0, omega and the bearing b unknown: an even disc that bears on its face up to e^b of its
/// radius. `mu` and `velocity` are the slide's; the sd counts what the angles scatter beyond their own.
/// nullopt where fewer than eight points show an angle, or the radius is not known.
std::optional<DiscSpin> slide_spin(const TrajectoryRun& run, double mu, const Eigen::Vector2d& velocity);
/// The same with mu and velocity as a first look at the positions has them, without spin.
std::optional<DiscSpin> first_slide_spin(const TrajectoryRun& run);

}  // namespace tribotrack::fit::internal
