// What lies in a synthetic scene: edges, the disc, the mark.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "vision/picture.h"
#include "vision/scene.h"
#include "vision/synthesis/camera.h"

namespace tribotrack::vision {

// Blurred circles, the pixels they touch and the pixels they fill: disc, marker and lamp are made of them.

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

// The disc of a synthetic scene: a blurred circle with scratches that turn with it and a highlight that does
// not.

/// Colour of the disc at (dx, dy) from its centre (pixels, y down):
///   level + highlight exp(-|d - h|^2 / (2 q^2)) + sum_j c_j G_j(u, v),   h = (-0.35 R, -0.35 R), q = 0.45 R,
/// (u, v) the disc-fixed coordinates, y up, that turn with theta. A scratch G is a straight line convolved
/// with a Gaussian: exp(-across^2 / (2 b^2)) [erf((along + l) / (sqrt2 b)) - erf((along - l) / (sqrt2 b))]
/// / 2. Scratches are alternately bright and dark, so the mean stays near `level`.
class DiscLayer {
 public:
  struct Scratch {
    double u = 0, v = 0;          ///< middle
    double cosine = 1, sine = 0;  ///< direction
    double half_length = 0;       ///< l
    double contrast = 0;          ///< c, signed
    double outermost = 0;         ///< nothing of it lies farther from the disc's centre
  };
  DiscLayer(const DiscAppearance& disc, std::uint64_t seed);

  const BlurredCircle& edge() const { return edge_; }
  /// Of the disc alone, as if it had no edge.
  double colour(double dx, double dy, double cosine, double sine) const;

  /// Pixel means, averaged over the exposure, written into the pixels the disc fills throughout it. They are
  /// given as one span per row of the picture.
  void render_interior(std::span<const ExposureNode> nodes, std::span<const PixelSpan> filled,
                       Picture& picture) const;

 private:
  double scratch_profile(const Scratch& scratch, double along, double across) const;
  // Means over the rule's nodes about a place.
  double mean_scratch(const Scratch& scratch, Point from_centre, double cosine, double sine,
                      const QuadratureRule& rule) const;
  double mean_scratches(Point from_centre, double cosine, double sine, const QuadratureRule& rule) const;
  /// Along one axis: exp(-(d - h)^2 / (2 q^2)).
  double mean_lobe(double from_centre, const QuadratureRule& rule) const;

  BlurredCircle edge_;
  double level_ = 0;
  double highlight_ = 0;
  double highlight_offset_ = 0;
  double highlight_width_ = 1;
  double scratch_blur_ = 1;
  std::vector<Scratch> scratches_;  // outermost first
  QuadratureRule point_, pixel_;
};

// The fiducial marker of a synthetic scene: a dark dot on a bright ring, fixed to the platform.

/// The ring's outer radius is the marker's radius, the dot's half of it. Both edges are blurred like the
/// disc's.
struct MarkerLayer {
  MarkerAppearance look;
  BlurredCircle ring, dot;
  MarkerLayer(const MarkerAppearance& marker, double edge_blur_px)
      : look(marker), ring{marker.radius_px, edge_blur_px}, dot{0.5 * marker.radius_px, edge_blur_px} {}
  double colour(double dx, double dy) const {
    return look.ring_level + (look.level - look.ring_level) * dot.coverage(dx, dy);
  }
};

}  // namespace tribotrack::vision
