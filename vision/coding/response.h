// Attenuation and delay of a coded motion, from the error that it leaves.
//
//   e = c0 + c1 t - a x - T dx/dt + noise
// by least squares over both coordinates (c0, c1 of each), x without its own straight line: a drift is not
// what comes back too small. For x = A cos wt the amplitude is (1 - a) A and the phase late by w T, to first
// order. The noise's own correlation in time counts in the standard deviations.
#pragma once

#include <vector>

#include "vision/picture.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// `seen` and `true_path` at every `interval` s. At least 16 points.
CodedResponse coded_response(const std::vector<Point>& seen, const std::vector<Point>& true_path,
                             double interval);

}  // namespace tribotrack::vision
