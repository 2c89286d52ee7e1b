// The halves' disagreement over a recording: how large, and which part of it changes slowly.
//
// Of e (halves.h) whitened by the reported covariance, in every frame and for every split:
//   total = mean of squares about the mean over the recording (a constant disagreement is no error of a
//           displacement),
//   white = half the mean square of differences between consecutive frames.
// Without slow errors they are the same number, and the variance of total - white is sigma^4 (3 / pairs - 2 /
// numbers) (von Neumann 1941); slow errors make the total the larger one.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/audit/mean_square.h"

namespace tribotrack::vision {

/// One audited frame.
struct AuditFrame {
  std::int64_t index = 0;  ///< in the source
  HalvesError error;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of this frame's position as reported
};

/// Of all splits together, in units of the reported covariance unless said otherwise.
struct HalvesFound {
  double left_right = 1, top_bottom = 1, checkerboard = 1;  ///< ratios of standard deviations
  MeanSquare total;
  MeanSquare white;        ///< the total where nothing is slow
  double slow_frames = 0;  ///< integral of the slow part's autocorrelation, frames; 0 where nothing is slow
  double unit = 0;         ///< px^2: mean of the reported variances of a coordinate
};

/// From frames in order; nullopt for fewer than 16, which tell no ratio to 10 %.
std::optional<HalvesFound> halves_found(const std::vector<AuditFrame>& frames);

}  // namespace tribotrack::vision
