// The track as the audit looks at it: each coordinate over each stretch of consecutive frames.
#pragma once

#include <vector>

#include "vision/track.h"

namespace tribotrack::vision {

/// Consecutive frames that are ok: positions, px, and their reported standard deviations.
struct Stretch {
  std::vector<double> x, y, sigma_x, sigma_y;
  std::size_t size() const { return x.size(); }
};

std::vector<Stretch> stretches(const Track& track);

/// One coordinate of a stretch.
struct Axis {
  std::vector<double> Stretch::*position;
  std::vector<double> Stretch::*sigma;
};
inline constexpr Axis kAlongX{&Stretch::x, &Stretch::sigma_x}, kAlongY{&Stretch::y, &Stretch::sigma_y};

}  // namespace tribotrack::vision
