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

}  // namespace tribotrack::vision
