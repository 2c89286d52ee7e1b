// Blurred circles, the pixels they touch and the pixels they fill: disc, marker and lamp are made of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Pixels first .. last of a row; empty when last < first.
struct PixelSpan {
  int first = 0;
  int last = -1;
  bool empty() const { return last < first; }
};

/// A sharp disc of radius R seen through Gaussian optics of sd s: the share of the Gaussian about a point at
/// distance rho that lies on the disc,
///   C(rho) = 1 - Q_1(rho/s, R/s),   dC/drho = -(R/s^2) exp(-(R^2 + rho^2) / (2 s^2)) I_1(rho R / s^2),
/// Q_1 Marcum's function. Its half height lies at R - s^2/(2 R), inside the rim, and its integral over the
/// plane is pi R^2, the disc's own area. Kept as a table in rho with cubic interpolation (error below 1e-7).
class BlurredCircle {
 public:
  BlurredCircle() = default;
  BlurredCircle(double radius, double blur);

  double radius() const { return radius_; }
  double blur() const { return blur_; }
  /// Beyond this distance from the rim the coverage is 0 or 1 to 2e-5 (for discs of 4 blurs and more).
  double reach() const { return 4.5 * blur_; }
  double coverage(double dx, double dy) const {
    const double rho = std::sqrt(dx * dx + dy * dy);
    const double place = (rho - first_) * cells_per_pixel_;
    if (rho - radius_ > reach() || table_.empty()) return 0;
    if (place <= 0) return radius_ >= reach() ? 1 : table_.front().value;
    const auto cell = std::min(static_cast<std::size_t>(place), table_.size() - 2);
    const double t = place - static_cast<double>(cell);
    const Node& a = table_[cell];
    const Node& b = table_[cell + 1];
    const double rise = b.value - a.value;
    return a.value +
           t * (a.slope + t * (3 * rise - 2 * a.slope - b.slope + t * (a.slope + b.slope - 2 * rise)));
  }

 private:
  struct Node {
    double value, slope;  ///< slope per cell
  };
  double radius_ = 0;
  double blur_ = 0;
  double first_ = 0;  ///< rho of the first node
  double cells_per_pixel_ = 0;
  std::vector<Node> table_;
};

/// Of one row of pixels: those a circle touches at one of its centres at least, and those it fills at all of
/// them. Both are spans, on the safe side: touched may hold too many, filled too few.
struct RowBand {
  PixelSpan touched;
  PixelSpan filled;
};
RowBand row_band(const BlurredCircle& circle, std::span<const Point> centres, int row, int width);

}  // namespace tribotrack::vision
