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

#include "vision/kernels/bspline.h"
#include "vision/kernels/plane.h"
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
// above) as a function of where the part is. Vignetting is nearly a parabola, its slope nearly
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
  Eigen::Vector3d terms(const Point& place) const { return {1, place.x - middle_.x, place.y - middle_.y}; }

  bool known_ = false;
  Point middle_;
  Eigen::Matrix<double, 3, 2> field_ = Eigen::Matrix<double, 3, 2>::Zero();
  Eigen::Matrix3d inverse_ = Eigen::Matrix3d::Zero();  ///< of the sum of terms terms^T
  double noise_ = 0, scatter_ = 0;  ///< variances: of a measured slope, of the light itself
};

// The platform's picture in its own frame, averaged over the frames in which it is uncovered, or seen beside
// the part: in its shadow, through the blur of its rim.

struct PartPictures;

/// G(u) - mean G, u a place of the platform: the camera's pixel it lies on where the displacement is zero.
/// Each frame is interpolated by its own quintic spline; a change of light from frame to frame is taken out
/// by the ratio of what both show.
class GroundPicture {
 public:
  explicit GroundPicture(const Rect& region);

  /// `picture` is a window of the frame whose first pixel is pixel (x, y). What lies in `hidden` (camera px)
  /// is not the ground.
  void add(const Picture& picture, int x, int y, const Point& displacement, const Circle& hidden);

  /// Forgets the frames.
  void forget() { away_ = PlaceSums(region_); }
  /// Share of the region that was uncovered in enough frames; after finish().
  double known_share() const { return known_share_; }

  /// To be called after the last frame.
  void finish(double noise_variance);
  /// And once the part's pictures are known: what the windows show of the ground within `hidden` px of the
  /// part where at least half of it shows, (I - a S) / (b alpha), takes the place of what was said before.
  /// The same for any number of threads.
  void see_beside(WindowSpan windows, const PartPictures& part, double hidden, double noise_variance,
                  int threads = 1);

  const Rect& region() const { return region_; }
  /// G - mean G, its variance and slopes at places (x0 + i, y0 + j); beyond the region as at its border.
  void sample(double x0, double y0, int width, int height, float* level, float* variance, float* slope_x,
              float* slope_y) const;
  /// Of G - mean G; 0 where the ground was never seen. Its first pixel is region()'s first place.
  const QuinticSpline& spline() const { return spline_; }
  /// Of G at the places of the region, grey levels^2: that of the estimate of least mean square error,
  ///   1 / (n / s^2 + 1 / t^2),
  /// s^2 what a place's level scatters by in time, n the frames that show it (alpha^2 counts of one that sees
  /// it beside the part), t the texture; so t^2 where it was never seen.
  const Picture& variance() const { return variance_; }
  double mean() const { return mean_; }

 private:
  void see_beside(const KeptWindow& window, int part_half, const QuinticSpline& level,
                  const QuinticSpline& share, double hidden, const Rect& rows);
  void form(double noise_variance);

  Rect region_;
  PlaceSums away_;         ///< where the part is away
  PlaceSums beside_;       ///< beside it, weighted by how much of the ground shows
  Picture frames_beside_;  ///< number of these
  Picture variance_;
  double mean_ = 0, unrest_ = 0, texture_ = 0, known_share_ = 0;
  QuinticSpline spline_;
};

// The part's two pictures and what they leave unexplained, by regression at every place of its grid.

inline constexpr double kPixelBlend = 1.0 / 12;

/// On a grid of 2 half + 1 places either way, the part's centre in its middle.
struct PartPictures {
  int half = 0;
  Picture level;     ///< F, grey levels
  Picture share;     ///< alpha: how much of the ground shows; 1 outside, 0 inside, less than 1 in the shadow
  Picture variance;  ///< V, grey levels^2, beside what is unsure of the ground
  double blend = kPixelBlend;  ///< kappa, px^2: of a square pixel, until the rim tells more
};

/// One regression over kept windows in their present states: at every place u of the grid the frames' levels
/// against what F and alpha are multiplied by,
///   I_k(c_k + u) = a F(u) + h alpha(u),   a = a_k (1 + s_k . u),   h = b_k G(c_k + u - p_k) - a mean G
/// two unknowns and the variance that is left. A frame weighs less where its ground is hardly known, by V
/// over V + alpha^2 b^2 var G. What `before` says of kappa is taken out first, and residuals are taken from
/// it. Levels that it does not explain within five standard deviations belong to something else (a hand, a
/// lamp) and are left out if `trim`. Where the ground shows no texture a weak prior keeps alpha what a
/// blurred rim lets through: no ground shows inside the rim's blur, where alpha is 0, and nowhere is it below
/// 0 or above 1.1. The same for any number of threads.
PartPictures learn_pictures(const PartPictures& before, const GroundPicture& ground, WindowSpan windows,
                            bool trim, double noise_variance, const Picture& prior_share, int threads = 1);

/// What shows of the ground beside a rim of this radius and blur: Phi((rho - R) / s).
Picture blurred_rim(int half, double radius, double blur);

}  // namespace tribotrack::vision
