// The layered model of a frame:
//   I_k(x) = a_k (1 + g_k . u) S(u) + b_k [w(u) B(x - p_k) + kappa grad w . grad B],   u = x - c_k
// with S the disc's premultiplied picture, w = 1 - alpha the share of the ground seen through its rim, B the
// platform's picture. A pixel shows the mean of the product of the sharp share and the sharp ground, which is
// not the product of their means: to first order the difference is kappa grad w . grad B, with kappa the
// variance of what blurs both together: 1/12 px^2 for a square pixel, and the optics' s^2. What differs from
// frame to frame stands here. The light's slope g_k absorbs vignetting and uneven lamps (illumination_slope.h), a_k
// and b_k flicker.
#pragma once

#include "vision/picture.h"

namespace tribotrack::vision {

struct LayeredState {
  Point centre;                     ///< c_k, px of the camera
  double theta = 0;                 ///< the disc's rotation, rad, counter-clockwise as seen (y up)
  Point ground;                     ///< p_k, the platform's displacement, px
  double gain = 1;                  ///< a_k
  double slope_x = 0, slope_y = 0;  ///< g_k, 1/px
  double ground_gain = 1;           ///< b_k
};

/// Variance of a pixel: a + b I, grey levels^2.
struct NoiseLaw {
  double constant = 1.0 / 12, per_level = 0;
  double at(double level) const { return constant + per_level * (level > 0 ? level : 0); }
};

}  // namespace tribotrack::vision
