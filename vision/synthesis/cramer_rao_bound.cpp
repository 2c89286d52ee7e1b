#include "vision/cramer_rao_bound.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tribotrack::vision {
namespace {

/// dI/dx or dI/dy by differences of sixth order: (45 f1 - 9 f2 + f3) / (60 h), f_n = f(n h) - f(-n h).
Picture slope(const SceneRenderer& renderer, double time_s, double exposure_s,
              const std::function<ScenePose(double)>& pose, double lamp_on_share, Point direction) {
  constexpr double h = 0.25;  // px: against edges of 0.5 px and more neither truncation nor floats matter
  constexpr std::array<double, 3> weights{45, -9, 1};
  const auto shifted = [&](double by) {
    const auto moved = [&](double t) {
      ScenePose p = pose(t);
      p.disc.x += by * direction.x;
      p.disc.y += by * direction.y;
      return p;
    };
    return renderer.render_exact(time_s, exposure_s, moved, lamp_on_share);
  };
  Picture result(renderer.scene().width, renderer.scene().height);
  for (int n = 1; n <= 3; ++n) {
    const Picture ahead = shifted(n * h);
    const Picture behind = shifted(-n * h);
    const auto weight = static_cast<float>(weights[n - 1] / (60 * h));
    for (std::size_t i = 0; i < result.levels().size(); ++i) {
      result.levels()[i] += weight * (ahead.levels()[i] - behind.levels()[i]);
    }
  }
  return result;
}

}  // namespace

Eigen::Matrix2d position_bound(const SceneRenderer& renderer, double time_s, double exposure_s,
                               const std::function<ScenePose(double)>& pose, double lamp_on_share) {
  const Scene& scene = renderer.scene();
  const double scale = std::ldexp(1.0, scene.bits - 8);
  const double top = std::ldexp(1.0, scene.bits) - 1;
  const Picture level = renderer.render_exact(time_s, exposure_s, pose, lamp_on_share);
  const Picture slope_x = slope(renderer, time_s, exposure_s, pose, lamp_on_share, {1, 0});
  const Picture slope_y = slope(renderer, time_s, exposure_s, pose, lamp_on_share, {0, 1});

  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < level.levels().size(); ++i) {
    const double mean = level.levels()[i];
    if (mean < 0 || mean > top) continue;
    const double variance =
        (scene.read_noise * scene.read_noise + scene.shot_noise * mean / scale) * scale * scale + 1.0 / 12;
    const Eigen::Vector2d gradient(slope_x.levels()[i], slope_y.levels()[i]);
    information += gradient * gradient.transpose() / variance;
  }
  if (!(information.determinant() > 1e-12 * information.squaredNorm())) {
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()).asDiagonal();
  }
  return information.inverse();
}

}  // namespace tribotrack::vision
