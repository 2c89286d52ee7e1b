// A tracked path, smoothed as far as the track's own errors allow.
#pragma once

#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Local parabolas over 2 h + 1 points [Savitzky and Golay, Anal. Chem. 36 (1964) 1627], h up to 12 and as
/// large as leaves no more than `sigma` px rms of the path.
std::vector<Point> smooth_path(const std::vector<Point>& path, double sigma);

}  // namespace tribotrack::vision
