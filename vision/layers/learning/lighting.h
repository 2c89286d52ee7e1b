// The light that stands in the picture among the layers: learnt in turn with them, taken out of the windows
// and the platform's picture.
//
// Known limits: on plain ground a spot both narrow and bright (sd 10 px, a third of the disc's level) may
// leave positions several times the bound off, told too sure; on ground that moves the share of L and H is
// told weakly, and positions stay some times the bound off.
#pragma once

#include <span>
#include <vector>

#include "vision/layers/learning/light.h"

namespace tribotrack::vision {

class LayeredLighting {
 public:
  LayeredLighting(const Rect& region, double top_level) : light_(region, top_level) {}

  /// One round: the light from windows in their present states over the present layers; windows and ground
  /// are changed to what the scene shows without it. False where the windows do not determine it.
  bool learn(std::span<KeptWindow> windows, const LayeredDisc& disc, GroundPicture& ground,
             const NoiseLaw& noise);
  bool found() const { return !covariance_.empty(); }
  const StaticIllumination& light() const { return light_; }
  /// What is not known of the light moves a disc here by so much, px^2: that of the nearest window. found()
  /// only.
  const Eigen::Matrix2d& covariance(const Point& centre) const;
  /// Places of the windows as the light was learnt from them.
  const std::vector<Point>& learnt_from() const { return learnt_from_; }

 private:
  StaticIllumination light_;
  std::vector<Point> learnt_from_;
  std::vector<Eigen::Matrix2d> covariance_;
};

}  // namespace tribotrack::vision
