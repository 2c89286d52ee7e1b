// Where in a track the part slides freely, and first guesses from it.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "fit/problem.h"

namespace tribotrack::fit::internal {

/// Points on either side that a smoothed speed is taken over.
inline constexpr std::size_t kSpeedWindow = 3;

/// Speeds over windows of 2 kSpeedWindow + 1 points, m/s; the i-th belongs to point i + kSpeedWindow. Empty
/// for fewer points.
std::vector<double> smoothed_speeds(const TrackTable& track);
/// About the highest of smoothed speeds, those that are no less than a small share of it.
struct Motion {
  std::size_t first = 0, fastest = 0, last = 0;
  /// As a part that slides down an incline until something stops it; else it was struck and is braked.
  bool gains_speed() const { return fastest - first > last - fastest; }
};
Motion find_motion(const std::vector<double>& speeds);
/// That share. A slower part may still be held by the hand that lets it go; the way left out is its square.
inline constexpr double kStillSlow = 0.15;

/// The points from `first` on, after the strike: those after the maximum of the smoothed speed. A track whose
/// speed is highest at its beginning is used whole, but for first steps that are a tenth shorter than that
/// speed; so is one on an incline that gains speed. Throws DataError for fewer than
/// eight points or a part that never moves.
struct FreeSlideGuess {
  std::size_t first = 0;
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< at `first`, m/s
  double mu = 0;
};
FreeSlideGuess guess_free_slide(const TrajectoryRun& run);

}  // namespace tribotrack::fit::internal
