// Light that stands in the picture, as a moving part meets it: the slope s of the light over the part (see
// state.h) as a function of where the part is. Vignetting is nearly a parabola, its slope nearly
// linear in the place:
//   s(c) = s_0 + S (c - c_0), fitted to the slopes of single frames by least squares.
// A frame by itself would pay for its two slopes with precision; holding them to one value for all places
// instead would draw the part the same way in every frame of a stretch of the path.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "vision/layers/model/part.h"
#include "vision/layers/model/state.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// What is known of the light's slope before a frame is looked at: at first that there is none.
struct LightPrior {
  double slope_x = 0, slope_y = 0;  ///< 1/px
  double sd = 0;                    ///< of each; 0: held there
};

/// One frame's slope, measured without a prior.
struct MeasuredSlope {
  Point place;                      ///< of the part, px
  double slope_x = 0, slope_y = 0;  ///< 1/px
  double variance = 0;              ///< of each
};

class IlluminationSlope {
 public:
  /// Even light.
  IlluminationSlope() = default;
  /// At least four slopes.
  explicit IlluminationSlope(std::span<const MeasuredSlope> slopes);

  /// Whether the light is uneven beyond chance.
  bool known() const { return known_; }
  /// With the variance of a frame's own light about the field (lamps are not linear, flicker is not even) and
  /// of the field at this place.
  LightPrior at(const Point& place) const;

 private:
  Eigen::Vector3d terms(const Point& place) const;

  bool known_ = false;
  Point middle_;
  Eigen::Matrix<double, 3, 2> field_ = Eigen::Matrix<double, 3, 2>::Zero();
  Eigen::Matrix3d inverse_ = Eigen::Matrix3d::Zero();  ///< of the sum of terms terms^T
  double noise_ = 0, scatter_ = 0;  ///< variances: of a measured slope, of the light itself
};

// Light that stands in the picture and falls on the part as it passes: a lamp's glare, the edge of a beam.

/// L(x), grey levels at pixels of the camera, added where the part covers the ground: (1 - alpha) L. On
/// ground at rest it stands in the ground's own picture. It is learnt over the part's face alone, away from
/// the rim, where it cannot be taken for a motion, and continued smoothly by a few pixels.
class StandingLight {
 public:
  /// The region that windows lie in, and what shows of the ground on the part's grid.
  StandingLight(const Rect& region, const Picture& share);

  /// What the windows leave unexplained within `inside` px of the part's centre, in their present states:
  /// sets the evidence.
  void look(const std::vector<KeptWindow>& windows, const PartPictures& part, double inside);
  /// And it adds to L, and is taken out of the windows.
  void learn(std::vector<KeptWindow>& windows, const PartPictures& part, double inside);
  /// Mean square of what stands at a pixel over what changes there from frame to frame, both per frame: 1
  /// where nothing stands in the picture.
  double evidence() const { return evidence_; }

  /// Takes (1 - alpha) L out of a window whose first pixel is pixel (x, y), the part being at `centre`.
  void take_out(Picture& picture, int x, int y, const Point& centre) const {
    take_out(level_, picture, x, y, centre);
  }

 private:
  void take_out(const Picture& light, Picture& picture, int x, int y, const Point& centre) const;

  Rect region_;
  int half_;
  QuinticSpline share_;
  Picture level_;
  Picture sum_, count_;  ///< of the last look
  double evidence_ = 1;
};

}  // namespace tribotrack::vision
