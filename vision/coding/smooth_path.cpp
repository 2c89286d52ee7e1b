#include "vision/coding/smooth_path.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr int kWidest = 12;

std::vector<Point> parabolas(const std::vector<Point>& path, int half) {
  const int n = static_cast<int>(path.size());
  std::vector<Point> out;
  for (int k = 0; k < n; ++k) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 2> sums = Eigen::Matrix<double, 3, 2>::Zero();
    for (int i = std::max(0, k - half); i <= std::min(n - 1, k + half); ++i) {
      const double t = i - k;
      const Eigen::Vector3d basis(1, t, t * t);
      const Point& p = path[static_cast<std::size_t>(i)];
      normal += basis * basis.transpose();
      sums += basis * Eigen::RowVector2d(p.x, p.y);
    }
    const Eigen::Matrix<double, 3, 2> fit = normal.ldlt().solve(sums);
    out.push_back({fit(0, 0), fit(0, 1)});
  }
  return out;
}

double rms_between(const std::vector<Point>& a, const std::vector<Point>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    sum += std::pow(a[k].x - b[k].x, 2) + std::pow(a[k].y - b[k].y, 2);
  return std::sqrt(sum / (2.0 * static_cast<double>(std::max<std::size_t>(1, a.size()))));
}

}  // namespace

std::vector<Point> smooth_path(const std::vector<Point>& path, double sigma) {
  std::vector<Point> best = path;
  for (int half = 2; half <= kWidest && 2 * half < static_cast<int>(path.size()); ++half) {
    std::vector<Point> smooth = parabolas(path, half);
    if (rms_between(smooth, path) > sigma) break;
    best = std::move(smooth);
  }
  return best;
}

}  // namespace tribotrack::vision
