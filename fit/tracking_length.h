// How well a tracked length is known at best.
#pragma once

#include <cmath>

namespace tribotrack::fit {

/// Relative sd of every length that is tracked, however well the scale is told: registration against a
/// picture learnt from the recording itself sees ways short by some thousandths of a pixel (rendered
/// recordings of known truth: 1.6e-5 and 1.9e-5 over 3.7 to 22 mm). It moves mu2 by several standard
/// deviations of a trajectory fit and is not seen in its residuals, because the parameters take it up.
constexpr double kTrackedLengthSd = 2e-5;

/// Of a scale told with the relative sd `told`.
inline double tracked_scale_sd(double told) {
  return std::hypot(told, kTrackedLengthSd);
}

}  // namespace tribotrack::fit
