// The platform's ground as learnt from many frames: what registers the others to it.
//
// A frame shows I(x) = a G(x - p) + b(x): G the ground on its own grid, which is that of the first frame's
// pixels, p its displacement since, a the light's gain and b what light adds, smooth over a block of pixels.
// Of a large picture the window that holds the most information is taken.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/kernels/bspline.h"
#include "vision/picture.h"

namespace tribotrack::vision {

struct Ground {
  Rect place;          ///< of the window that is learnt, on the ground's grid
  Picture mean;        ///< grey levels
  Picture variance;    ///< of a frame's pixel about it, grey levels^2
  Picture seen;        ///< in so many frames; 0 where in too few to be known
  Picture quiet;       ///< the mean freed of its noise
  QuinticSpline less;  ///< of `quiet` less `level`
  float level = 0;     ///< mean, taken off before sums are formed
};

/// A frame as far as it may show the ground.
struct GroundFrame {
  std::int64_t index = 0;
  Rect window;                 ///< of the frame
  Picture picture;             ///< in it
  std::vector<Circle> hidden;  ///< the part with its shadow, the lamp
  Point start;                 ///< displacement to refine
};

/// How far the ground lies from where it was learnt.
struct GroundFix {
  Point displacement;                                    ///< px
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< px^2
  double score = 0;             ///< correlation with the learnt ground, what is smooth over a block taken off
  double gain = 1, offset = 0;  ///< of the light: I = gain G + offset
  double trimmed_share = 0;     ///< of the pixels: something else lies over the ground
};

}  // namespace tribotrack::vision
