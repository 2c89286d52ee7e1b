// What is smooth along the rings about the part's centre: the blurred rim is, and a shadow.
#pragma once

#include "vision/picture.h"

namespace tribotrack::vision {

/// What observations at the places of a ring have in common, and what no number of them averages out.
struct RingLimit {
  const Picture& observations;  ///< at each place
  double most = 0;              ///< that a ring's count for: all of its places together
};

/// `values` at the places of a square grid, each of information `weights`, fitted on every ring, a pixel wide
/// and linear between, by 1, cos phi, sin phi, cos 2 phi, sin 2 phi. Coefficients are 0 but for chance of
/// this sd beforehand, so that rings of which little is known stay flat. Where a ring has more observations
/// than `limit`, if any, their information is that of so many.
Picture ring_fit(const Picture& values, const Picture& weights, double sd, const RingLimit* limit = nullptr);

}  // namespace tribotrack::vision
