// Two complementary halves of the pixels: do they agree on where the part is?
//
// A frame is registered by weighted least squares: parameters p (position, then nuisances such as gain), at
// whose optimum the scores s = sum w J r of all pixels add up to 0. With N = sum w J J^T over all pixels and
// N_A over those of one half, the model (white noise of variance 1 / w) says of the half's score at the
// common optimum
//   s_A = J_A^T W (n - J N^-1 J^T W n)   =>   E s_A = 0,   Cov s_A = N_A - N_A N^-1 N_A = S.
// Without nuisances s_A = N_A (d_A - d) = S (d_A - d_B): the disagreement of the halves' own positions, whose
// covariance is N_A^-1 + N_B^-1 = S^-1. With them its position part s_Ap, of covariance S_pp, is what the
// halves' disagreement does to the position. Whitened, and given the covariance C of the position itself,
//   e = chol(C) chol(S_pp)^-1 s_Ap,   Cov e = C,
// it is what an error of the position would look like if the disagreement is typical of it. Where something
// else than white noise is in the pictures, e is larger than C says. A shift of the whole part that all
// pixels agree on does not show, and of noise that is alike all over a half gain and offset take a part: for
// noise that tiles share e is some 0.8 times as large as the error (halves_test.cpp).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Sums over one tile of 8 x 8 pixels at the optimum of a registered frame. Parameters: x, y, then nuisances
/// (gain, offset, ...); weights are 1 / variance of a level.
struct TileSums {
  static constexpr int kMost = 8;  ///< parameters
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMost>;
  /// The tile's middle, px from the part's centre on the part's own grid: the same from frame to frame.
  Point place;
  Vector score;   ///< sum of w J r
  Matrix normal;  ///< sum of w J J^T
};

/// Of each split a vector, px, whose covariance is that of the position if the model is right. The splits are
/// the part's left against its right half, its top against its bottom, and every other tile.
struct HalvesError {
  Eigen::Vector2d left_right, top_bottom, checkerboard;
};

/// `normal` over all pixels that took part, in tiles or not, and what is known beforehand; `covariance` of
/// the position, px^2. nullopt where a half tells too little about the position.
std::optional<HalvesError> halves_error(std::span<const TileSums> tiles, const TileSums::Matrix& normal,
                                        const Eigen::Matrix2d& covariance);

/// The same with the position's block of the inverse of `normal` as its covariance.
std::optional<HalvesError> halves_error(std::span<const TileSums> tiles, const TileSums::Matrix& normal);

}  // namespace tribotrack::vision
