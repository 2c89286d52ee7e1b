// A point of a track states its errors as two standard deviations and their correlation.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace tribotrack::vision {

template <class Point>
Eigen::Matrix2d covariance_of(const Point& p) {
  const double off = p.rho_xy * p.sigma_x * p.sigma_y;
  return Eigen::Matrix2d{{p.sigma_x * p.sigma_x, off}, {off, p.sigma_y * p.sigma_y}};
}

template <class Point>
void set_covariance(Point& p, const Eigen::Matrix2d& covariance) {
  p.sigma_x = std::sqrt(covariance(0, 0));
  p.sigma_y = std::sqrt(covariance(1, 1));
  p.rho_xy = covariance(0, 1) / (p.sigma_x * p.sigma_y);
}

}  // namespace tribotrack::vision
