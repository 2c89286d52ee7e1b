// A judge of tracks that owes nothing to the tracker's rims: where is the circle? On 96 rays about a first
// guess the picture's spline falls from the mean level inside to that outside; where it is half way is the
// edge. A circle is fitted to these edges, those far from it left out.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "vision/kernels/bspline.h"

namespace tribotrack::vision::test {

inline Circle circle_fit(const Picture& picture, Circle c) {
  constexpr int kRays = 96, kSteps = 48;
  constexpr double kReach = 6;  // px beside the rim
  const QuinticSpline spline(picture);
  for (int round = 0; round < 3; ++round) {
    std::vector<Eigen::Vector4d> edges;  // direction, 1, distance of the edge from the rim
    for (int k = 0; k < kRays; ++k) {
      const double ux = std::cos(2 * M_PI * k / kRays), uy = std::sin(2 * M_PI * k / kRays);
      std::vector<double> level, at;
      double inside = 0, outside = 0;
      for (int i = 0; i <= 2 * kSteps; ++i) {
        at.push_back(kReach * (i - kSteps) / kSteps);
        const double rho = c.radius + at.back();
        level.push_back(spline.value(c.x + rho * ux, c.y + rho * uy));
        if (i < kSteps / 2) inside += level.back() / (kSteps / 2);
        if (i > 3 * kSteps / 2) outside += level.back() / (kSteps / 2);
      }
      const double half = 0.5 * (inside + outside);
      double edge = 1e9;
      for (std::size_t i = 0; i + 1 < level.size(); ++i) {
        const double a = (level[i] - half) * (inside - half), b = (level[i + 1] - half) * (inside - half);
        const double place = a > 0 && b <= 0 ? at[i] + a / (a - b) * (at[i + 1] - at[i]) : 1e9;
        if (std::abs(place) < std::abs(edge)) edge = place;
      }
      if (edge < 1e9) edges.emplace_back(ux, uy, 1, edge);
    }
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    double most = 1e9;
    for (int again = 0; again < 4; ++again) {
      Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      std::vector<double> sizes;
      for (const Eigen::Vector4d& e : edges) {
        const Eigen::Vector3d u = e.head<3>();
        sizes.push_back(std::abs(e(3) - u.dot(step)));
        if (sizes.back() >= most) continue;
        normal += u * u.transpose();
        right += u * e(3);
      }
      step = normal.ldlt().solve(right);
      for (std::size_t i = 0; i < edges.size(); ++i)
        sizes[i] = std::abs(edges[i](3) - edges[i].head<3>().dot(step));
      std::nth_element(sizes.begin(), sizes.begin() + static_cast<long>(sizes.size() / 2), sizes.end());
      most = 3 * std::max(0.02, 1.4826 * sizes[sizes.size() / 2]);
    }
    c = {c.x + step(0), c.y + step(1), c.radius + step(2)};
  }
  return c;
}

}  // namespace tribotrack::vision::test
