// The line in the spectrum of a track's positions that stands for a motion that repeats.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fit/motion.h"

namespace tribotrack::fit::internal {

/// Points in the order of time, some of a track or means of several that follow each other.
struct Series {
  std::vector<double> time;
  std::vector<Eigen::Vector2d> position;
  std::size_t size() const { return time.size(); }
  double span() const { return time.back() - time.front(); }
};

/// Means of as many points as leave no more than `most`, of the rows [first, last).
Series thinned(const TrackTable& track, std::size_t first, std::size_t last, std::size_t most);

/// As fit/motion.h says what a line is. Looked for in means over the whole track, then in the points of its
/// middle, whose cycles those means may hide.
std::optional<Oscillation> find_oscillation(const TrackTable& track);

}  // namespace tribotrack::fit::internal
