// Light that stands in the picture and falls on the part as it passes: a lamp's glare, the edge of a beam.
#pragma once

#include <vector>

#include "vision/layers/model/part.h"
#include "vision/layers/model/state.h"

namespace tribotrack::vision {

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
