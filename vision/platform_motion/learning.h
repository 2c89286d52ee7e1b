// The ground learnt from frames spread over a recording.
//
// In turn: every frame is registered to the mean of all, and the mean formed anew of the frames sampled at
// their displacements on the ground's grid, light's gain and offset taken out, pixels left out that show
// something else, until the displacements settle. The variance about the mean at each place is the weight
// that place has.
#pragma once

#include <optional>
#include <vector>

#include "vision/platform_motion/ground.h"

namespace tribotrack::vision {

struct LearntGround {
  Ground ground;
  std::vector<std::optional<GroundFix>> fixes;           ///< of the frames learnt from
  Eigen::Matrix2d excess = Eigen::Matrix2d::Identity();  ///< see GroundRegistration
  double texture = 0;                                    ///< grey levels rms beyond the noise
  double score = 0;                                      ///< their median
  int rounds = 0;
};

/// From frames whose `start` is good to a texture's width. `place` of the window; `noise_variance` of a
/// pixel, the least that is believed. Nothing where too few frames can be registered: the ground shows
/// nothing.
std::optional<LearntGround> learn_ground(const std::vector<GroundFrame>& frames, const Rect& place,
                                         double noise_variance, int most_rounds);

}  // namespace tribotrack::vision
