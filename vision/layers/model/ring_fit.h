// What is smooth along the rings about the part's centre: the blurred rim is, and a shadow.
#pragma once

#include "vision/picture.h"

namespace tribotrack::vision {

/// `values` at the places of a square grid, each of information `weights`, fitted on every ring, a pixel wide
/// and linear between, by 1, cos phi, sin phi, cos 2 phi, sin 2 phi. Coefficients are 0 but for chance of
/// this sd beforehand, so that rings of which little is known stay flat.
Picture ring_fit(const Picture& values, const Picture& weights, double sd);

}  // namespace tribotrack::vision
