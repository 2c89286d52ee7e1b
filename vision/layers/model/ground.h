// The platform's picture in its own frame, averaged over the frames in which it is uncovered or seen through
// the disc's rim.
#pragma once

#include <span>
#include <vector>

#include "vision/kernels/bspline.h"
#include "vision/layers/model/static_illumination.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// B(u), u a place of the platform: the camera's pixel it lies on where the displacement is zero. Each frame
/// is interpolated by its own quintic spline; a change of light from frame to frame is taken out by the ratio
/// of what both show.
class GroundPicture {
 public:
  explicit GroundPicture(const Rect& region);

  /// `picture` is a window of the frame whose first pixel is pixel (x, y). What lies in `hidden` (camera px)
  /// is not the ground.
  void add(const Picture& picture, int x, int y, const Point& displacement, const Circle& hidden);

  /// Forgets the frames; of those added from now on only what lies within `tolerance` grey levels of `usual`
  /// (over the region, in any light) is the ground: the rest is something that crosses it.
  void hold_to(Picture usual, double tolerance);
  /// Share of what was uncovered that was the ground.
  double held_share() const { return looked_at_ > 0 ? held_ / looked_at_ : 1; }

  /// What is seen of place (u, v) through the rim, where the ground's share is w: adds w (I - S) and w^2.
  void add_through_rim(int u, int v, float weighted, float square) {
    if (u < region_.x || v < region_.y || u >= region_.x + region_.width || v >= region_.y + region_.height)
      return;
    if (!standing_out_.empty() && standing_out_.at(u - region_.x, v - region_.y) > 0) return;
    through_.at(u - region_.x, v - region_.y) += weighted;
    squares_through_.at(u - region_.x, v - region_.y) += square;
  }
  void forget_rim();

  /// Light that stood in the pictures added, which were displaced by `displacements`: finish() takes it out
  /// of their mean. A place averages what it was seen in.
  void set_light(const StaticIllumination& light, std::span<const Point> displacements);

  /// To be called after the last frame. Small patches far brighter or darker than the ground's texture may be
  /// a lamp before the disc as well as a mark beneath it: they are not the ground.
  void leave_out_what_stands_out(double noise_variance);

  /// To be called after the last frame, and again when the rim has told more. A place seen too seldom is held
  /// to a smooth continuation of its neighbours, by a prior wide enough for a texture that errs in patches.
  void finish(double noise_variance);

  const Rect& region() const { return region_; }
  /// B at places (x0 + i, y0 + j); known 1 where it was uncovered in enough frames, else 0. Slopes may
  /// be null.
  void sample(double x0, double y0, int width, int height, float* value, float* known,
              float* slope_x = nullptr, float* slope_y = nullptr) const;
  /// The same with slopes over tiles whose first places are `tiles` places from (x0, y0); `corners` is
  /// scratch.
  void sample_tiles(double x0, double y0, const std::vector<TilePlace>& tiles,
                    std::vector<const float*>& corners, TileArrays& arrays, std::vector<float>& known) const;
  /// B's spline; its first pixel is region()'s first place.
  const QuinticSpline& spline() const { return spline_; }
  /// Variance of B at the places of the region: the noise's over the number of frames, up to
  /// unseen_variance() where a place was never seen.
  const Picture& variance() const { return variance_; }
  double unseen_variance() const { return unseen_variance_; }
  double mean() const { return mean_; }
  /// Median variance of a place's level in time, grey levels^2: the noise's where the displacements are
  /// right.
  double unrest() const { return unrest_; }
  /// Grey levels rms beyond the noise, over all places that are known.
  double texture() const { return texture_; }

 private:
  void summarise(const Picture& enough, const Picture& level, double noise_variance);
  void lean_on_neighbours(const Picture& seen, const Picture& own);

  bool not_ground(std::size_t place) const {
    return (!standing_out_.empty() && standing_out_.levels()[place] > 0) ||
           (!light_hidden_.empty() && light_hidden_.levels()[place] > 0);
  }
  template <class Uncovered>
  void add_held(const Uncovered& uncovered);
  Rect region_;
  Picture standing_out_;  ///< 1 where something does; empty without
  Picture usual_;         ///< see hold_to(); empty without
  float tolerance_ = 0;
  double held_ = 0, looked_at_ = 0;
  Picture light_gain_, light_offset_, light_hidden_;  ///< means over the displacements; empty without
  Picture sum_, squares_, count_, through_, squares_through_, known_, variance_;
  double mean_ = 0, unrest_ = 0, texture_ = 0, unseen_variance_ = 1;
  QuinticSpline spline_;
};

}  // namespace tribotrack::vision
