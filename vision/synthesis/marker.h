// The fiducial marker of a synthetic scene: a dark dot on a bright ring, fixed to the platform.
#pragma once

#include "vision/scene.h"
#include "vision/synthesis/edge.h"

namespace tribotrack::vision {

/// The ring's outer radius is the marker's radius, the dot's half of it. Both edges are blurred like the
/// disc's.
class MarkerLayer {
 public:
  MarkerLayer(const MarkerAppearance& marker, double edge_blur_px)
      : ring_{marker.radius_px, edge_blur_px},
        dot_{0.5 * marker.radius_px, edge_blur_px},
        level_(marker.level),
        ring_level_(marker.ring_level) {}

  const BlurredCircle& ring() const { return ring_; }
  const BlurredCircle& dot() const { return dot_; }
  double level() const { return level_; }
  double ring_level() const { return ring_level_; }
  /// How much of the platform it hides at (dx, dy) from its centre, and its own colour there.
  double coverage(double dx, double dy) const { return ring_.coverage(dx, dy); }
  double colour(double dx, double dy) const {
    return ring_level_ + (level_ - ring_level_) * dot_.coverage(dx, dy);
  }

 private:
  BlurredCircle ring_;
  BlurredCircle dot_;
  double level_ = 0;
  double ring_level_ = 0;
};

}  // namespace tribotrack::vision
