// What a sine leaves of the marker's motion: multiples of w, a drift of w, coloured noise.
#pragma once

#include <optional>
#include <vector>

#include "fit/measurement.h"
#include "fit/measuring/sine_fit.h"

namespace tribotrack::fit::internal {

struct SineResiduals {
  double near_w = 1;  ///< power of the residuals beside w over that of white noise of the track's sigma
  /// Variance of a cosine or sine coefficient at w by errors that repeat every cycle, m^2: mean square of the
  /// coefficients at 4w and above beyond their noise. 0 where the frames do not resolve them.
  double repeating_variance = 0;
  std::optional<Estimate> frequency_drift;  ///< rad/s^2
  std::vector<Harmonic> harmonics;
};

/// `noise_factor`: variance of the marker's noise over its sigma squared.
SineResiduals analyse_residuals(const MarkerSeries& marker, const SineFit& fit, double noise_factor);

}  // namespace tribotrack::fit::internal
