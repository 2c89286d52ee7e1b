// Where in a track the part slides freely, and first guesses from it.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "fit/problem.h"

namespace tribotrack::fit::internal {

/// The points [first, last) after the strike: those after the maximum of the smoothed speed. A track whose
/// speed is highest at its beginning is used whole, but for first steps that are a tenth shorter than that
/// speed. Throws DataError for fewer than eight points or a part that never moves.
struct FreeSlideGuess {
  std::size_t first = 0, last = 0;
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< at `first`, m/s
  double mu = 0;
};
FreeSlideGuess guess_free_slide(const TrajectoryRun& run);

}  // namespace tribotrack::fit::internal
