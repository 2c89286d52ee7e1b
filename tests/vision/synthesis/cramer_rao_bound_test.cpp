#include "vision/cramer_rao_bound.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace tribotrack::vision {
namespace {

Scene plain(double radius) {
  Scene scene;
  scene.width = scene.height = 2 * static_cast<int>(radius) + 21;
  scene.disc.radius_px = radius;
  scene.disc.level = 170;
  scene.disc.scratches = 0;
  scene.disc.highlight = 0;
  scene.platform.level = 80;
  scene.platform.texture_rms = 0;
  scene.read_noise = 1.5;
  return scene;
}

std::function<ScenePose(double)> at_rest(Point disc, Point platform = {}) {
  return [=](double) { return ScenePose{disc, 0.4, platform}; };
}

/// For one coordinate of a plain disc at rest on a plain platform under white noise: (sigma / A) sqrt(2 s /
/// (sqrt(pi) R)), s the edge's sd with the pixel's own 1/12 px^2, sigma with the 1/12 of rounding.
double plain_disc_bound(double radius_px, double contrast, double edge_sd_px, double noise_sd) {
  return noise_sd / contrast * std::sqrt(2 * edge_sd_px / (std::sqrt(std::numbers::pi) * radius_px));
}

TEST(PositionBound, TendsToTheClosedFormOnAPlainPlatform) {
  for (const double radius : {12.0, 30.0, 60.0}) {
    for (const double blur : {0.5, 0.8, 1.5}) {
      Scene scene = plain(radius);
      scene.disc.edge_blur_px = blur;
      const double middle = scene.width / 2.0 - 0.4;
      const Eigen::Matrix2d bound =
          position_bound(SceneRenderer(scene), 0, 0, at_rest({middle, middle + 0.3}));
      const double closed =
          plain_disc_bound(radius, 90, std::sqrt(blur * blur + 1.0 / 12), std::sqrt(1.5 * 1.5 + 1.0 / 12));
      EXPECT_NEAR(std::sqrt(bound(0, 0)) / closed, 1, 0.01) << radius << " " << blur;
      EXPECT_NEAR(std::sqrt(bound(1, 1)) / closed, 1, 0.01) << radius << " " << blur;
      EXPECT_NEAR(bound(0, 1) / bound(0, 0), 0, 0.01);
    }
  }
}

TEST(PositionBound, IsReachedByTheEfficientEstimate) {
  // One Gauss-Newton step from the truth with the same weights: its covariance is the bound, if the
  // renderer's noise is what it says it is. Read noise, shot noise and rounding on a brushed platform.
  Scene scene = plain(9);
  scene.disc.scratches = 5;
  scene.platform.texture_rms = 8;
  scene.shot_noise = 0.02;
  const SceneRenderer renderer(scene);
  const Point centre{19.3, 18.8};
  const auto pose = at_rest(centre, {0.7, -0.4});
  const Picture exact = renderer.render_exact(0, 0, pose);
  const double h = 0.02;
  const auto slope = [&](double dx, double dy) {
    const Picture a = renderer.render_exact(0, 0, at_rest({centre.x + dx, centre.y + dy}, {0.7, -0.4}));
    const Picture b = renderer.render_exact(0, 0, at_rest({centre.x - dx, centre.y - dy}, {0.7, -0.4}));
    std::vector<double> g;
    for (std::size_t i = 0; i < a.levels().size(); ++i) {
      g.push_back((static_cast<double>(a.levels()[i]) - b.levels()[i]) / (2 * h));
    }
    return g;
  };
  const auto gx = slope(h, 0), gy = slope(0, h);
  const Eigen::Matrix2d bound = position_bound(renderer, 0, 0, pose);
  const int frames = 4000;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (int k = 0; k < frames; ++k) {
    const Picture frame = renderer.render(k, 0, 0, pose);
    Eigen::Vector2d score = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < gx.size(); ++i) {
      const double level = exact.levels()[i];
      const double residual = (frame.levels()[i] - level) / (2.25 + 0.02 * level + 1.0 / 12);
      score += residual * Eigen::Vector2d(gx[i], gy[i]);
    }
    const Eigen::Vector2d d = bound * score;
    mean += d / frames;
    covariance += d * d.transpose() / frames;
  }
  const double sd = std::sqrt(bound(0, 0));
  EXPECT_NEAR(mean.x() / sd, 0, 4 / std::sqrt(frames));
  EXPECT_NEAR(mean.y() / sd, 0, 4 / std::sqrt(frames));
  EXPECT_NEAR(covariance(0, 0) / bound(0, 0), 1, 4 * std::sqrt(2.0 / frames));
  EXPECT_NEAR(covariance(1, 1) / bound(1, 1), 1, 4 * std::sqrt(2.0 / frames));
  EXPECT_NEAR((covariance(0, 1) - bound(0, 1)) / bound(0, 0), 0, 4 / std::sqrt(frames));
}

TEST(PositionBound, FollowsTheMotionBlurOfEveryPartOfTheRim) {
  // At the angle a the rim's Gaussian is convolved with a box of w = path |cos a|, and the integral of its
  // square is the mean of N(u; 0, 2 s^2) over the triangle of half width w.
  const double radius = 30, path = 4, s = std::sqrt(0.64 + 1.0 / 12);
  double information = 0;
  const int angles = 720, steps = 400;
  for (int i = 0; i < angles; ++i) {
    const double a = 2 * M_PI * (i + 0.5) / angles;
    const double w = path * std::abs(std::cos(a));
    double square = 0;
    for (int j = 0; j < steps; ++j) {
      const double u = 2 * w * ((j + 0.5) / steps - 0.5);
      square +=
          (1 - std::abs(u) / w) * 2 / steps * std::exp(-u * u / (4 * s * s)) / std::sqrt(4 * M_PI * s * s);
    }
    information += std::cos(a) * std::cos(a) * square * 2 * M_PI / angles * radius;
  }
  const double expected = std::sqrt((2.25 + 1.0 / 12) / information) / 90;
  const auto pose = [&](double t) { return ScenePose{{40.3 + path * t, 39.8}, 0, {}}; };
  const Eigen::Matrix2d bound = position_bound(SceneRenderer(plain(radius)), 0, 1, pose);
  EXPECT_NEAR(std::sqrt(bound(0, 0)) / expected, 1, 0.01);
}

TEST(PositionBound, IsInfiniteWithoutADiscInThePicture) {
  Scene scene = plain(10);
  EXPECT_TRUE(std::isinf(position_bound(SceneRenderer(scene), 0, 0, at_rest({-50, 10}))(0, 0)));
  scene.disc.level = 900;  // saturated, and so is all of its rim that could be seen
  scene.platform.level = 300;
  EXPECT_TRUE(std::isinf(position_bound(SceneRenderer(scene), 0, 0, at_rest({20, 20}))(1, 1)));
}

}  // namespace
}  // namespace tribotrack::vision
