// One disc's rim in many frames: what belongs to the disc is learnt and taken out.
//
// The deviation of sector k in frame t is p_tk + r_tk: p, the median over the frames about t, is what the
// lamp and the lens make of this rim (a chamfer, a shadow); it does not turn. r is what moves: noise, the
// ground's texture, a mark that turns. The circle is fitted to the edges less p with Hampel's psi [Hampel
// et al., Robust statistics (1986)], and the covariance of its centre is N^-1 (sum i^2 v u u^T) N^-1, i the
// edge's information, u its direction, v_tk the mean of psi(r)^2 in the frames nearby: it holds whatever r
// comes from, as long as sectors err independently, and is never less than what the noise does. What moves
// all of the rim slowly is not in it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/discs/rim_sectors.h"

namespace tribotrack::vision {

/// Where the disc was in a frame.
struct RimFix {
  Point centre;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< px^2
};

/// One frame's rim, in the camera's coordinates.
struct RimFrame {
  std::int64_t frame = 0;
  RimSectors rim;
};

/// Of frames in order; all with as many sectors. Noise in grey levels^2.
std::vector<RimFix> fix_centres(const std::vector<RimFrame>& frames, double noise_variance);

}  // namespace tribotrack::vision
