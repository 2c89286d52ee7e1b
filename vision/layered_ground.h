// The platform's picture in its own frame, averaged over the frames in which it is uncovered.
#pragma once

#include "vision/bspline.h"
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
  /// To be called once, after the last frame. Places never uncovered are filled smoothly and marked unknown.
  void finish();

  const Rect& region() const { return region_; }
  /// B at places (x0 + i, y0 + j); known 1 where it was uncovered in enough frames, else 0.
  void sample(double x0, double y0, int width, int height, float* value, float* known) const;
  double mean() const { return mean_; }
  /// Median variance of a place's level in time, grey levels^2: the noise's where the displacements are
  /// right.
  double unrest() const { return unrest_; }

 private:
  Rect region_;
  Picture sum_, squares_, count_, known_;
  double mean_ = 0, unrest_ = 0;
  QuinticSpline spline_;
};

}  // namespace tribotrack::vision
