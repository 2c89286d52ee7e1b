// What the errors of a layered track have in common.
//
// The learnt ground errs, and it errs alike in all frames whose rim lies over the same places. Positions c_k
// of the windows and the ground B are one least-squares problem. With B eliminated, the information on the
// positions is
//   T - C,   C_kl = sum over places a_k var_B a_l^T  (k != l),   a_k = b w dM/dc / var  of the pixel of
//   window
//            k that shows the place,
// T the blocks of a frame's own information, in which var_B counts as white noise, and with D = T + C_kk that
// of a frame whose ground were known,
//   Cov = (T - C)^-1 = D^-1 + slow,
// slow being what a frame's error shares with the others': for a new frame at the place of a window, too,
// whose own noise D^-1 is its own. A shift common to all windows is no error of a displacement and is taken
// out; the disc's picture, which errs alike in all frames, makes such a shift.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/layers/model/ground.h"

namespace tribotrack::vision {

/// What one window's position leans on.
struct GroundLean {
  std::int64_t frame = 0;
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  ///< T_k, px^-2
  struct Pull {
    std::uint32_t place = 0;  ///< of the ground's picture, row after row
    float x = 0, y = 0;       ///< a_k
  };
  std::vector<Pull> pulls;
};

struct SlowError {
  double sd = 0;        ///< of one coordinate, px rms over the windows, their mean removed
  double frames = 0;    ///< over how many frames it stays alike: the integral of its correlation
  double widening = 1;  ///< variance of a coordinate, slow part included, over that of T alone
};

/// From windows in the order of their frames; all 0 where the problem is not solvable.
SlowError slow_error(const std::vector<GroundLean>& windows, const GroundPicture& ground);

}  // namespace tribotrack::vision
