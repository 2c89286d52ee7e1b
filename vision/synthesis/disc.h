// The disc of a synthetic scene: a blurred circle with scratches that turn with it and a highlight that does
// not.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vision/picture.h"
#include "vision/scene.h"
#include "vision/synthesis/edge.h"
#include "vision/synthesis/exposure.h"
#include "vision/synthesis/quadrature.h"

namespace tribotrack::vision {

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
  /// Outermost first.
  const std::vector<Scratch>& scratches() const { return scratches_; }
  /// Of the disc alone, as if it had no edge.
  double colour(double dx, double dy, double cos_theta, double sin_theta) const;

  /// Pixel means, averaged over the exposure, written into the pixels the disc fills throughout it. They are
  /// given as one span per row of the picture.
  void render_interior(std::span<const ExposureNode> nodes, std::span<const PixelSpan> filled,
                       Picture& picture) const;

 private:
  double scratch_profile(const Scratch& scratch, double along, double across) const;
  void add_highlight(const ExposureNode& node, std::span<const PixelSpan> filled, Picture& picture) const;
  void add_scratch(const Scratch& scratch, const ExposureNode& node, std::span<const PixelSpan> filled,
                   Picture& picture) const;

  BlurredCircle edge_;
  double level_ = 0;
  double highlight_ = 0;
  double highlight_offset_ = 0;
  double highlight_width_ = 1;
  double scratch_blur_ = 1;
  std::vector<Scratch> scratches_;
  QuadratureRule scratch_rule_;
};

}  // namespace tribotrack::vision
