// The model of a frame, "two pictures per place":
//   I_k(x) = a_k (1 + s_k . u) [F(u) - alpha(u) mean G]
//          + b_k [alpha(u) G(x - p_k) + kappa grad alpha . grad G],   u = x - c_k
// F is what a place shows on ground of mean level and alpha how much of the ground shows at a place of the
// part's own grid, which moves with the part and does not turn: the rim with the lens's blur, the shadow, the
// chamfer's glint and the highlight stand in these two pictures without a model of any. G is the platform's
// picture in its own frame. A pixel shows the mean of
// the product of the sharp share and the sharp ground, which is not the product of their means: to first
// order the difference is kappa grad alpha . grad G, kappa the variance of what blurs both together, that of
// the rim's blur. What is left at a place, V(u), is its variance over the frames, and 1 / V its weight:
// whatever the model lacks there weighs less by itself. Gains a_k and b_k take flicker, the slope s_k an
// uneven light on the part itself: on the ground it stands in G.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "vision/kernels/bspline.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// What differs from frame to frame.
struct LayeredState {
  Point centre;                     ///< c_k, px of the camera
  Point ground;                     ///< p_k, the platform's displacement, px
  double gain = 1;                  ///< a_k
  double slope_x = 0, slope_y = 0;  ///< s_k, 1/px
  double ground_gain = 1;           ///< b_k
};

/// A window of a frame that the pictures are learnt from.
struct KeptWindow {
  Picture picture;
  int x = 0, y = 0;  ///< its first pixel in the frame
  LayeredState state;
  QuinticSpline spline;
};

/// Some of the kept windows.
using WindowSpan = std::span<const KeptWindow* const>;

// Light that stands in the picture, as a moving part meets it: the slope s of the light over the part (see
// state.h) as a function of where the part is. Vignetting is nearly a parabola, its slope nearly
// linear in the place:
//   s(c) = s_0 + S (c - c_0), fitted to the slopes of single frames by least squares.
// A frame by itself would pay for its two slopes with precision; holding them to one value for all places
// instead would draw the part the same way in every frame of a stretch of the path.

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
