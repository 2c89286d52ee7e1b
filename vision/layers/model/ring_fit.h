// What is smooth along the rings about the part's centre: the blurred rim is, and a shadow.
#pragma once

#include <limits>

#include "vision/picture.h"

namespace tribotrack::vision {

/// `values` at the places of a square grid, each of information `weights`, fitted on every ring, a pixel wide
/// and linear between, by 1, cos phi, sin phi, cos 2 phi, sin 2 phi. Coefficients are 0 but for chance of
/// this sd beforehand, so that rings of which little is known stay flat. The places of a ring together tell
/// no more than `most`, what they have in common.
Picture ring_fit(const Picture& values, const Picture& weights, double sd,
                 double most = std::numeric_limits<double>::infinity());

}  // namespace tribotrack::vision
