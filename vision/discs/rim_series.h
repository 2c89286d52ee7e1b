// One disc's rim in many frames: what belongs to the disc is learnt and taken out.
//
// The deviation of sector k in frame t is p_k + r_tk: p, the median over the frames, is what the lamp and the
// lens make of this rim (a chamfer, a shadow); it does not turn. r is what moves: noise, the ground's texture,
// metal that turns under the lamp. The circle is fitted to the edges less p, and the covariance of its centre
// is N^-1 (sum w^2 v u u^T) N^-1 with v_tk the mean of r^2 in the frames nearby, so that it holds whatever r
// comes from, as long as sectors err independently.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "vision/discs/rim_sectors.h"

namespace tribotrack::vision {

/// Where the disc was in a frame.
struct RimFix {
  Point centre;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< px^2
};

/// Of frames in order; all with as many sectors, in the camera's coordinates.
std::vector<RimFix> fix_centres(const std::vector<RimSectors>& frames);

}  // namespace tribotrack::vision
