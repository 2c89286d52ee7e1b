// The step of the levels across a circle, direction by direction: is there a rim?
#pragma once

#include <utility>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

using Direction = std::pair<double, double>;  ///< cosine and sine
using Directions = std::vector<Direction>;

/// So many, evenly all round.
Directions directions(int count);
/// As many as the rim has pixels, about.
Directions rim_directions(double radius);

/// Linear between pixels; places beyond the picture are moved to its border.
double level_at(const Picture& picture, double x, double y);

/// Steps across the circle, inside minus outside, between places `half_width` px either side of it.
double rim_step(const Picture& picture, const Circle& circle, double half_width, const Direction& u);
std::vector<double> rim_steps(const Picture& picture, const Circle& circle, double half_width,
                              const Directions& around);

/// Share of the steps that have the sign of the usual one and at least 0.4 of its size.
double coverage_of(const std::vector<double>& steps, double usual);

/// Moves the circle uphill in the sum of steps across it, from up to `capture` px off; each step is capped so
/// that a few strong edges (a lamp, a neighbour) cannot outvote the rim. `polarity`: 1 for a bright disc, -1
/// for a dark one.
Circle climb_rim(const Picture& picture, Circle circle, double capture, double polarity,
                 const Directions& around);

}  // namespace tribotrack::vision
