#include <cmath>

#include "fit/measurement.h"

namespace tribotrack::fit {

Displacement with_scale_sd(Displacement displacement, double relative_sd) {
  displacement.covariance +=
      relative_sd * relative_sd * displacement.vector * displacement.vector.transpose();
  derive_alpha_and_v(displacement);
  return displacement;
}

PlatformMotion with_scale_sd(PlatformMotion motion, double relative_sd) {
  for (Estimate* length : {&motion.amplitude, &motion.amplitude_y})
    length->sd = std::hypot(length->sd, relative_sd * length->value);
  return motion;
}

}  // namespace tribotrack::fit
