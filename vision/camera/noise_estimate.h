// How noisy is a recording?
#pragma once

#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Variance of one pixel, grey levels^2, from consecutive frames: half the variance of their difference over
/// 8 x 8 px blocks, the mean over the blocks that noise alone explains (parts that move are a minority), the
/// mean over pairs. Blocks rather than pixels, so that a change of light cancels; clipped and black blocks
/// are left out. Of large pictures some rows of blocks, other ones in every pair. Never below the 1/12 of
/// rounding to whole levels. One picture alone: from second differences, which a texture of a few
/// pixels raises.
double noise_variance(const std::vector<Picture>& consecutive);

/// The same, pair by pair.
class NoiseEstimate {
 public:
  /// Consecutive frames.
  void add_pair(const Picture& a, const Picture& b);
  double variance(const Picture& first) const;

 private:
  double sum_ = 0;
  int pairs_ = 0;
};

/// From one picture (Immerkaer, "Fast noise variance estimation", CVIU 64, 1996), median over blocks.
double noise_variance(const Picture& picture);

}  // namespace tribotrack::vision
