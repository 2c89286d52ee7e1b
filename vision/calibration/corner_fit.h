// The corner of four squares, to a few thousandths of a pixel.
#pragma once

#include <optional>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Fits, by least squares over the pixels within `reach` px of `start`,
///   I(p) = m + g (p - q) + c erf(n1 (p - q) / (sqrt2 s)) erf(n2 (p - q) / (sqrt2 s)),
/// two edges of blur s crossing at q with normals n1, n2, on a shaded ground. The picture of a corner is the
/// same turned by half a turn, and so is the model: what it gets wrong of the edges does not move q. Nothing
/// where there is no such corner within 2 px.
std::optional<Point> fit_corner(const Picture& picture, Point start, double reach);

}  // namespace tribotrack::vision
