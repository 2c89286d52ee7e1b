#include "vision/scale.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tribotrack::vision {
namespace {

/// Chi-squared exceeded once in 1000, by the cube-root law of Wilson and Hilferty (1931), good to 1 % from 2
/// degrees of freedom on; 10.83 for one.
double chi2_of_one_in_thousand(int degrees) {
  if (degrees == 1) return 10.828;
  constexpr double normal = 3.0902;  // exceeded once in 1000
  const double spread = 2 / (9.0 * degrees);
  return degrees * std::pow(1 - spread + normal * std::sqrt(spread), 3);
}

}  // namespace

Scale scale_from_diameter(double diameter_mm, double radius_px, double radius_sd_px, double diameter_sd_mm) {
  if (!(diameter_mm > 0) || !(radius_px > 0))
    throw std::invalid_argument("the part's diameter must be greater than 0");
  const double mm_per_px = diameter_mm / (2 * radius_px);
  return {mm_per_px, mm_per_px * std::hypot(radius_sd_px / radius_px, diameter_sd_mm / diameter_mm),
          "part's diameter"};
}

Scale given_scale(double mm_per_px, double sd) {
  if (!(mm_per_px > 0)) throw std::invalid_argument("mm_per_px must be greater than 0");
  if (!(sd >= 0)) throw std::invalid_argument("mm_per_px_sd must not be negative");
  return {mm_per_px, sd, "given"};
}

PooledScale pooled_scale(std::span<const Scale> scales, double common_relative_sd) {
  if (scales.empty()) throw std::invalid_argument("no scale to take the mean of");
  PooledScale pooled;
  pooled.count = static_cast<int>(scales.size());
  pooled.scale = scales.front();
  const auto own_variance = [&](const Scale& s) {
    const double common = common_relative_sd * s.mm_per_px;
    return std::max(0.0, s.sd * s.sd - common * common);
  };
  const bool exact =
      std::any_of(scales.begin(), scales.end(), [&](const Scale& s) { return own_variance(s) <= 0; });
  if (exact) {
    for (const Scale& s : scales)
      pooled.agree = pooled.agree && s.mm_per_px == scales.front().mm_per_px && s.sd == scales.front().sd;
    return pooled;
  }
  double weights = 0, sum = 0;
  for (const Scale& s : scales) {
    weights += 1 / own_variance(s);
    sum += s.mm_per_px / own_variance(s);
  }
  const double mean = sum / weights;
  for (const Scale& s : scales) pooled.chi2 += std::pow(s.mm_per_px - mean, 2) / own_variance(s);
  pooled.scale.mm_per_px = mean;
  pooled.scale.sd = std::hypot(1 / std::sqrt(weights), common_relative_sd * mean);
  pooled.agree = pooled.count == 1 || pooled.chi2 <= chi2_of_one_in_thousand(pooled.count - 1);
  return pooled;
}

}  // namespace tribotrack::vision
