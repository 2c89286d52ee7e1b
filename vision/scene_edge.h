// Blurred circles, the pixels they touch and the pixels they fill: disc, marker and lamp are made of them.
#pragma once

#include <cmath>
#include <limits>
#include <span>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Pixels first .. last of a row; empty when last < first.
struct PixelSpan {
  int first = 0;
  int last = -1;
  bool empty() const { return last < first; }
};

/// Coverage falls from 1 inside to 0 outside as 0.5 erfc((rho - R) / (sqrt2 s)): an edge seen through
/// Gaussian optics of sd s. Its integral over the plane is pi (R^2 + s^2).
struct BlurredCircle {
  double radius = 0;
  double blur = 0;

  /// Beyond this distance from the rim the coverage is 0 or 1 to 4e-6.
  double reach() const { return 4.5 * blur; }
  double coverage(double dx, double dy) const {
    const double outside = std::sqrt(dx * dx + dy * dy) - radius;
    if (outside > reach()) return 0;
    if (outside < -reach()) return 1;
    return 0.5 * std::erfc(outside / (std::sqrt(2.0) * blur));
  }
};

/// Of one row of pixels: those a circle touches at one of its centres at least, and those it fills at all of
/// them. Both are spans, on the safe side: touched may hold too many, filled too few.
struct RowBand {
  PixelSpan touched;
  PixelSpan filled;
};
RowBand row_band(const BlurredCircle& circle, std::span<const Point> centres, int row, int width);

}  // namespace tribotrack::vision
