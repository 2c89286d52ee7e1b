// The likelihood of one edge of a gate, from frames that were lit before and dark after it or the reverse.
#pragma once

#include <vector>

#include "fit/measurement.h"

namespace tribotrack::fit::internal {

/// One frame near an edge, in phases relative to a first guess of the edge. With the edge at or below `low`
/// the frame's mean level is `level_below`, at or above `high` it is `level_above`, linear between.
struct EdgeFrame {
  double low = 0, high = 0;  ///< rad
  double level = 0;
  double level_below = 0, level_above = 0;
  double sigma_below = 1, sigma_above = 1;  ///< of the level
  /// Brightness between the two levels shows only that the edge is inside (a saturated lamp, an unknown
  /// exposure).
  bool only_inside = false;
};

struct EdgeEstimate {
  Estimate edge;      ///< rad, relative to the guess
  double jitter = 0;  ///< rad rms
};

/// Mean and standard deviation of the edge under a flat prior, by quadrature. `reach`: the edge lies within
/// +- reach of the guess, rad. `resolution`: a jitter or spacing below this does not matter, rad.
EdgeEstimate estimate_edge(const std::vector<EdgeFrame>& frames, double reach, double resolution);

}  // namespace tribotrack::fit::internal
