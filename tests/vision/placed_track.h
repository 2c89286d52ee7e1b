// A track's points in millimetres as tests ask for them: one scale for both planes.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "vision/millimetres.h"

namespace tribotrack::vision::test {

struct MillimetrePoint {
  double x_mm = 0, y_mm = 0, sigma_x_mm = 0, sigma_y_mm = 0, rho_xy = 0;
};

inline std::vector<std::optional<MillimetrePoint>> in_millimetres(const Track& track, double mm_per_px,
                                                                  double xi_axis_rad) {
  const PlaneGeometry geometry({mm_per_px, 0, "given"}, ScalePlane::part_top, std::nullopt);
  std::vector<std::optional<MillimetrePoint>> out;
  for (const auto& p : place_track(track, geometry, xi_axis_rad)) {
    out.emplace_back();
    if (!p) continue;
    const Eigen::Matrix2d& c = p->covariance;
    out.back() = {p->mm.x(), p->mm.y(), std::sqrt(c(0, 0)), std::sqrt(c(1, 1)),
                  c(0, 1) / std::sqrt(c(0, 0) * c(1, 1))};
  }
  return out;
}

}  // namespace tribotrack::vision::test
