#include "vision/synthesis/exposure.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "vision/synthesis/quadrature.h"

namespace tribotrack::vision {
namespace {

constexpr int kPathSteps = 16;
constexpr double kAtRest = 1e-9;  // px

ScenePose checked_pose(const std::function<ScenePose(double)>& pose, double time_s) {
  const ScenePose p = pose(time_s);
  for (const double value : {p.disc.x, p.disc.y, p.theta, p.platform.x, p.platform.y}) {
    if (!std::isfinite(value)) {
      throw std::invalid_argument("the pose at t = " + std::to_string(time_s) + " s is not finite");
    }
  }
  return p;
}

double distance(Point a, Point b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace

std::vector<ExposureNode> exposure_nodes(double time_s, double exposure_s,
                                         const std::function<ScenePose(double)>& pose, double radius_px,
                                         double smallest_blur_px, double largest_wave_number,
                                         double tolerance) {
  if (!(exposure_s >= 0) || !std::isfinite(exposure_s) || !std::isfinite(time_s)) {
    throw std::invalid_argument("time and exposure must be finite and the exposure not negative");
  }
  if (exposure_s == 0) return {{1.0, checked_pose(pose, time_s)}};

  double path_disc = 0, path_platform = 0;
  ScenePose previous = checked_pose(pose, time_s - exposure_s / 2);
  for (int i = 1; i <= kPathSteps; ++i) {
    const ScenePose next =
        checked_pose(pose, time_s + exposure_s * (static_cast<double>(i) / kPathSteps - 0.5));
    path_disc += distance(previous.disc, next.disc) + radius_px * std::abs(next.theta - previous.theta);
    path_platform += distance(previous.platform, next.platform);
    previous = next;
  }
  const double path = std::max(path_disc, path_platform);
  if (path < kAtRest) return {{1.0, checked_pose(pose, time_s)}};

  const int points = std::max(gauss_points_for_edge(smallest_blur_px / path, tolerance),
                              gauss_points_for_wave(largest_wave_number * path, tolerance));
  const QuadratureRule rule = gauss_legendre(points);
  std::vector<ExposureNode> nodes;
  for (int i = 0; i < points; ++i) {
    nodes.push_back({rule.weights[i], checked_pose(pose, time_s + exposure_s * rule.nodes[i])});
  }
  return nodes;
}

}  // namespace tribotrack::vision
