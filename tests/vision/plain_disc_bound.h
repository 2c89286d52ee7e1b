// The Cramer-Rao bound of a plain disc in closed form.
#pragma once

#include <cmath>
#include <numbers>

namespace tribotrack::vision::test {

/// For one coordinate of a plain disc at rest on a plain platform under white noise: (sigma / A) sqrt(2 s /
/// (sqrt(pi) R)), s the edge's sd with the pixel's own 1/12 px^2, sigma with the 1/12 of rounding.
inline double plain_disc_bound(double radius_px, double contrast, double edge_sd_px, double noise_sd) {
  return noise_sd / contrast * std::sqrt(2 * edge_sd_px / (std::sqrt(std::numbers::pi) * radius_px));
}

}  // namespace tribotrack::vision::test
