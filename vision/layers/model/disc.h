// The disc's own picture, learnt from kept windows of the recording.
//
//   S(u; theta) = S0(u) + alpha(|u|) S1(R(theta)^T u),   u = x - c,
// S0 what stands still while the disc turns (its rim, its shading, the lamp's reflection), S1 what turns with
// it (scratches, print); see split.h.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "vision/kernels/bspline.h"
#include "vision/kernels/informative_pixels.h"
#include "vision/layers/model/ground.h"
#include "vision/layers/model/rim.h"
#include "vision/layers/model/split.h"
#include "vision/layers/model/state.h"
#include "vision/layers/model/static_illumination.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// A window of a frame kept in memory, its first pixel at pixel (x, y) of the frame.
struct KeptWindow {
  Picture picture;
  int x = 0, y = 0;
  LayeredState state;
  QuinticSpline spline;        ///< of the picture, unseen pixels as they are
  std::int64_t frame = 0;      ///< in the source
  bool partly_unseen = false;  ///< see static_illumination.h
  bool explained = true;       ///< by the layers: else nothing is learnt from it
  /// Whether the camera's pixel next to a place shows the scene.
  bool sees(double place_x, double place_y) const {
    const int i = static_cast<int>(std::lround(place_x)) - x, j = static_cast<int>(std::lround(place_y)) - y;
    return i >= 0 && j >= 0 && i < picture.width() && j < picture.height() &&
           !StaticIllumination::unseen(picture.at(i, j));
  }
};

/// The window's pixels from (left, top) of it on, unseen ones as they are. Not by the window's own spline
/// where it can be avoided: each would keep its working memory.
void as_seen(const KeptWindow& window, int left, int top, int width, int height, float* levels);

class LayeredDisc {
 public:
  static constexpr double kTurningBytes = 48e6;  ///< that the pictures of a turning disc may take

  /// Pictures reach `half` px beyond the centre in every direction.
  LayeredDisc(double radius, double blur, bool turning);
  static int half_of(double radius, double blur);

  /// One sweep: w, S0 and S1 from the windows in their present states. Light is normalised: the mean of a_k
  /// is 1, the mean of g_k is 0, which changes the states accordingly.
  /// `where` (on the grid, null: everywhere) and about the rim: what is not 0 there stays as it was.
  void learn(std::span<KeptWindow> windows, const GroundPicture& ground, double noise_variance,
             const Picture* where = nullptr);

  /// The standing picture and the rim, to go back to or to go on from.
  struct Standing {
    Picture picture;
    std::vector<double> knots;
  };
  Standing standing() const { return {parts_.standing, rim_.knots()}; }
  void set_standing(const Standing& known);
  /// The standing picture taken about a place off the middle of the grid.
  void shift_standing(const Point& by);

  int half() const { return half_; }
  double radius() const { return radius_; }
  bool turning() const { return turning_; }
  const RimProfile& rim() const { return rim_; }
  /// w on the grid -half .. half.
  const Picture& share() const { return share_; }
  /// kappa of state.h, px^2.
  double blend() const { return blend_; }
  void set_blend(double kappa) { blend_ = kappa; }
  /// S on the grid at a rotation, and its derivative with respect to it (null where not wanted).
  Picture at(double theta, Picture* slope = nullptr) const;
  /// The disc on a plain ground of this level, at a rotation midway through what it has learnt from.
  Picture on_plain(double level) const;

 private:
  struct Sums;
  struct Place;
  Place place(const KeptWindow& window) const;
  void learn_standing(std::span<const KeptWindow> windows, const GroundPicture& ground, double noise_variance,
                      const std::vector<TilePlace>& tiles);
  std::vector<TilePlace> tiles_about_rim(const Picture* where) const;
  void learn_turning(std::span<const KeptWindow> windows, const GroundPicture& ground, double noise_variance);
  void make_share();

  double radius_ = 0;
  bool turning_ = false;
  RimProfile rim_;
  int half_ = 0;
  double blend_ = 1.0 / 12;
  Picture share_, share_x_, share_y_;
  StandingAndTurning parts_;
  QuinticSpline texture_spline_;
  double middle_theta_ = 0;
};

}  // namespace tribotrack::vision
