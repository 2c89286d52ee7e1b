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
// noise that tiles share e is some 0.8 times as large as the error.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "vision/kernels/dense.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// Of numbers that a right model scales to a variance of 1.
struct MeanSquare {
  double value = 1;
  double scatter = 0;  ///< standard deviation of the value
};

/// The least size a number of these must have to be an outlier: five standard deviations as the median size
/// tells them; infinite where more than a quarter are larger, which are then no outliers.
double outlier_size(const std::vector<double>& numbers);

/// What a covariance must be multiplied by, 1 or more, for the sake of an excess x = value - 1 that is known
/// to the scatter s: 1 + x (1 - (2 s / x)^2) from x = 2 s on, else 1 (Breiman's non-negative garrote,
/// Technometrics 37, 1995). A right model is widened in one case of 44, and then by little; a large excess is
/// taken as it is.
double supported(const MeanSquare& found);

/// Sums over one tile of 8 x 8 pixels at the optimum of a registered frame. Parameters: x, y, then nuisances
/// (gain, offset, ...); weights are 1 / variance of a level.
struct TileSums {
  using Vector = Few;
  using Matrix = FewByFew;
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

/// One audited frame.
struct AuditFrame {
  std::int64_t index = 0;  ///< in the source
  HalvesError error;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of this frame's position as reported
};

/// The halves' disagreement over a recording: how large, and which part of it changes slowly. Of e whitened
/// by the reported covariance, in every frame and for every split:
///   total = mean of squares about the mean over the recording (a constant disagreement is no error of a
///           displacement),
///   white = half the mean square of differences between consecutive frames.
/// Without slow errors they are the same number, and the variance of total - white is sigma^4 (3 / pairs - 2
/// / numbers) (von Neumann 1941); slow errors make the total the larger one. In units of the reported
/// covariance unless said otherwise.
struct HalvesFound {
  double left_right = 1, top_bottom = 1;  ///< ratios of standard deviations
  MeanSquare total;                       ///< of all splits together
  MeanSquare white;                       ///< the total where nothing is slow
  double slow_frames = 0;  ///< integral of the slow part's autocorrelation, frames; 0 where nothing is slow
  double unit = 0;         ///< px^2: mean of the reported variances of a coordinate
};

/// From frames in order; nullopt for fewer than 16, which tell no ratio to 10 %.
std::optional<HalvesFound> halves_found(const std::vector<AuditFrame>& frames);

/// Which frames are audited: runs of consecutive ones, spread over the recording. Long enough to tell what
/// changes from frame to frame from what changes slowly.
inline constexpr std::int64_t kAuditRun = 8;
/// A ratio of standard deviations pooled over three splits of two coordinates is then known to 1.8 %.
inline constexpr std::int64_t kAuditFrames = 256;

/// Whether the frame at this place (0 .. total - 1) lies in one of them; all of a short recording do.
bool in_audit(std::int64_t place, std::int64_t total);

}  // namespace tribotrack::vision
