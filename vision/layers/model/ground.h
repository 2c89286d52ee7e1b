// The platform's picture in its own frame, averaged over the frames in which it is uncovered, or seen beside
// the part: in its shadow, through the blur of its rim.
#pragma once

#include <span>
#include <vector>

#include "vision/kernels/bspline.h"
#include "vision/kernels/plane.h"
#include "vision/layers/model/state.h"
#include "vision/picture.h"

namespace tribotrack::vision {

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
  void forget();
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
  /// G - mean G and its variance at places (x0 + i, y0 + j); beyond the region as at its border. Slopes may
  /// be null, both together.
  void sample(double x0, double y0, int width, int height, float* level, float* variance,
              float* slope_x = nullptr, float* slope_y = nullptr) const;
  /// Of G - mean G; 0 where the ground was never seen. Its first pixel is region()'s first place.
  const QuinticSpline& spline() const { return spline_; }
  /// Of G at the places of the region, grey levels^2: that of the estimate of least mean square error,
  ///   1 / (n / s^2 + 1 / t^2),
  /// s^2 what a place's level scatters by in time, n the frames that show it (alpha^2 counts of one that sees
  /// it beside the part), t the texture; so t^2 where it was never seen.
  const Picture& variance() const { return variance_; }
  double mean() const { return mean_; }
  /// Grey levels rms beyond the noise, over all places that are known.
  double texture() const { return texture_; }

 private:
  void see_beside(const KeptWindow& window, int part_half, const QuinticSpline& level,
                  const QuinticSpline& share, double hidden, const Rect& rows);
  void summarise(double noise_variance);
  void form(double noise_variance);

  Rect region_;
  PlaceSums away_;         ///< where the part is away
  PlaceSums beside_;       ///< beside it, weighted by how much of the ground shows
  Picture frames_beside_;  ///< number of these
  Picture variance_;
  double mean_ = 0, unrest_ = 0, texture_ = 0, known_share_ = 0;
  QuinticSpline spline_;
};

}  // namespace tribotrack::vision
