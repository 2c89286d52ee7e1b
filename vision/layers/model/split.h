// Which part of a disc's picture turns with it, and which stands still?
#pragma once

#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// The disc seen at one rotation (rad, counter-clockwise with y up), on a square grid about its centre;
/// weight is the number of frames behind each pixel.
struct TurnedPicture {
  double theta = 0;
  Picture level, weight;
};

struct StandingAndTurning {
  Picture standing, turning;
  std::vector<float> coefficients;  ///< of the turning picture's spline: where the next call goes on
};

/// Least squares for  level_k(u) = standing(u) + cover(u) turning(R(theta_k)^T u)  over all pictures, by
/// conjugate gradients on the normal equations; `turning` is a quintic spline whose coefficients are the
/// unknowns, held to zero by a ridge of `ridge` frames. Small rotations tell the two apart only weakly where
/// the picture varies slowly round the disc, which plain alternation would take hundreds of rounds to learn.
///
/// One thing they do not tell apart at all: a rim whose picture has a component cos(phi) that turns, and a
/// disc that moves in proportion to its rotation. The rim is taken to be round about the pivot: beyond
/// `round_from` px from the centre the turning picture has no such component.
/// `known` holds the start and the result.
void split_turning(const std::vector<TurnedPicture>& pictures, const Picture& cover, double ridge,
                   double round_from, int iterations, StandingAndTurning& known);

}  // namespace tribotrack::vision
