// How far a part can move before its coder notices.
//
// Where another frame predicts a block, what the prediction leaves is transformed, and coefficients below
// z steps of the quantiser are dropped (z: Coder::dead_zone). A displacement d along x leaves d dI/dx. So
// nothing of it is coded up to
//   d0 = z step / m,   m = max_k |DCT(dI/dx)_k|,
// with the mean of m over the blocks about the rim, weighed by their information (dI/dx)^2: the blocks that
// tell most of a displacement are the first to notice it. For a straight edge of contrast c along the grid,
// blurred by less than half a block, the largest coefficient of its slope is sqrt(2) c in blocks of 4 x 4 and
// 8 x 8 alike: d0 = 0.59 step / c for x264.
#pragma once

#include "vision/picture.h"

namespace tribotrack::vision {

/// px that a part can move along x and y unnoticed, for a dead zone of one grey level. Of what lies within
/// `margin` px of the circle's line; negative: all of the circle's inside as well. 0 where nothing shows.
Point unnoticed_motion(const Picture& picture, const Circle& rim, double margin);

}  // namespace tribotrack::vision
