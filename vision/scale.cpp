#include "vision/scale.h"

#include <cmath>
#include <stdexcept>

namespace tribotrack::vision {

Scale scale_from_diameter(double diameter_mm, double radius_px, double radius_sd_px, double blur_px) {
  if (!(diameter_mm > 0) || !(radius_px > 0))
    throw std::invalid_argument("the part's diameter must be greater than 0");
  const double mm_per_px = diameter_mm / (2 * radius_px);
  const double rim_sd = std::hypot(radius_sd_px, blur_px * blur_px / (4 * radius_px));
  return {mm_per_px, mm_per_px * rim_sd / radius_px, "part's diameter"};
}

Scale given_scale(double mm_per_px) {
  if (!(mm_per_px > 0)) throw std::invalid_argument("mm_per_px must be greater than 0");
  return {mm_per_px, 0, "given"};
}

}  // namespace tribotrack::vision
