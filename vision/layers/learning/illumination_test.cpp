#include "vision/layers/learning/illumination_test.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <vector>

namespace tribotrack::vision {
namespace {

constexpr double kBent = 5;  ///< mean square of three numbers of unit variance: once in 600

/// Second-order light over the disc, S (u^2, uv, v^2) with (u, v) in radii, beside the frame's own gain and
/// slope.
struct Bend {
  Eigen::Vector3d size;
  Eigen::Matrix3d information;
};

Bend bend_of(const KeptWindow& w, const LayeredDisc& disc, const QuinticSpline& standing,
             const NoiseLaw& noise, std::vector<float>& shown) {
  const LayeredState& state = w.state;
  const double inner = disc.rim().inner() - 1;
  const int reach = static_cast<int>(std::ceil(inner)), size = 2 * reach + 1;
  const int left = static_cast<int>(std::lround(state.centre.x)) - reach;
  const int top = static_cast<int>(std::lround(state.centre.y)) - reach;
  shown.resize(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  standing.sample_window(left - state.centre.x + disc.half(), top - state.centre.y + disc.half(), size, size,
                         shown.data(), nullptr, nullptr);
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> force = Eigen::Matrix<double, 6, 1>::Zero();
  std::size_t k = 0;
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i, ++k) {
      const double u = (left + i - state.centre.x) / inner, v = (top + j - state.centre.y) / inner;
      if (u * u + v * v > 1 || !w.sees(left + i, top + j)) continue;
      const double s = shown[k];
      const double shine = state.gain * (1 + inner * (state.slope_x * u + state.slope_y * v));
      const double r = static_cast<double>(w.picture.at(left + i - w.x, top + j - w.y)) - shine * s;
      Eigen::Matrix<double, 6, 1> column;
      column << s, u * s, v * s, u * u * s, u * v * s, v * v * s;
      const double weight = 1 / noise.at(s);
      normal.noalias() += weight * column * column.transpose();
      force += weight * r * column;
    }
  const Eigen::Matrix3d own = normal.inverse().bottomRightCorner<3, 3>();
  return {normal.ldlt().solve(force).tail<3>(), own.inverse()};
}

}  // namespace

double curved_light_share(std::span<const KeptWindow> windows, const LayeredDisc& disc,
                          const NoiseLaw& noise) {
  if (windows.empty()) return 0;
  const auto n = static_cast<double>(windows.size());
  QuinticSpline standing(disc.at(0));
  std::vector<float> shown;
  std::vector<Bend> bends;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const KeptWindow& w : windows) {
    if (disc.turning()) standing = QuinticSpline(disc.at(w.state.theta));
    bends.push_back(bend_of(w, disc, standing, noise, shown));
    mean += bends.back().size / n;
  }
  // What all windows share is an error of the disc's own picture.
  int bent = 0;
  for (const Bend& b : bends) bent += (b.size - mean).dot(b.information * (b.size - mean)) / 3 > kBent;
  return bent / n;
}

}  // namespace tribotrack::vision
