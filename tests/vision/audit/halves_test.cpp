#include "vision/audit/halves.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <random>

namespace tribotrack::vision {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// A round part of radius 24 px: pixels of its rim with the slopes of a soft edge, over tiles of 8 x 8; the
/// parameters are x, y, gain, offset. Pixels are noisier on the right, as bright places are.
struct RimModel {
  struct Pixel {
    double x, y, weight;
    Eigen::Vector4d slope;
    std::size_t tile;
  };
  std::vector<Pixel> pixels;
  std::vector<TileSums> tiles;
  MatrixXd normal = MatrixXd::Zero(4, 4);

  RimModel() {
    constexpr double kRadius = 24;
    for (int ty = -4; ty < 4; ++ty)
      for (int tx = -4; tx < 4; ++tx) {
        TileSums tile;
        tile.place = {8.0 * tx + 3.5, 8.0 * ty + 3.5};
        tile.normal = MatrixXd::Zero(4, 4);
        for (int j = 0; j < 8; ++j)
          for (int i = 0; i < 8; ++i) {
            const double x = 8 * tx + i, y = 8 * ty + j, r = std::hypot(x, y), edge = r - kRadius;
            if (std::abs(edge) > 4) continue;
            const double slope = 20 * std::exp(-0.5 * edge * edge);
            Pixel p{x, y, x > 0 ? 0.5 : 1.0, {}, tiles.size()};
            p.slope << slope * x / r, slope * y / r, edge < 0 ? 1 : 0.1, 1;
            tile.normal += p.weight * p.slope * p.slope.transpose();
            pixels.push_back(p);
          }
        if (tile.normal.isZero()) continue;
        normal += tile.normal;
        tiles.push_back(tile);
      }
  }

  /// Registers a frame of which only the noise at each pixel is given: position found, and the tiles' sums
  /// there.
  Vector2d solve(const std::function<double(const Pixel&)>& noise) {
    VectorXd force = VectorXd::Zero(4);
    std::vector<double> levels;
    for (const Pixel& p : pixels) {
      levels.push_back(noise(p));
      force += p.weight * p.slope * levels.back();
    }
    const VectorXd found = normal.ldlt().solve(force);
    for (TileSums& tile : tiles) tile.score = VectorXd::Zero(4);
    for (std::size_t k = 0; k < pixels.size(); ++k)
      tiles[pixels[k].tile].score +=
          pixels[k].weight * pixels[k].slope * (levels[k] - pixels[k].slope.dot(found));
    return found.head<2>();
  }
};

constexpr int kFrames = 3000;

/// Against the covariance that the model gives the position.
std::optional<HalvesError> halves_of(const RimModel& model) {
  return halves_error(model.tiles, model.normal, MatrixXd(model.normal.inverse()).topLeftCorner<2, 2>());
}

/// Mean of e C^-1 e' of each split and of the position's own error, per coordinate.
struct Ratios {
  double left_right = 0, top_bottom = 0, checkerboard = 0, position = 0;
};

Ratios simulate(const std::function<std::function<double(const RimModel::Pixel&)>(std::mt19937&)>& frame) {
  RimModel model;
  const MatrixXd inverse = model.normal.inverse();
  const Eigen::Matrix2d information = inverse.topLeftCorner<2, 2>().inverse();
  std::mt19937 random(20);
  Ratios out;
  for (int k = 0; k < kFrames; ++k) {
    const Vector2d position = model.solve(frame(random));
    const auto halves = halves_of(model);
    EXPECT_TRUE(halves.has_value());
    const auto square = [&](const Vector2d& e) { return e.dot(information * e) / (2 * kFrames); };
    out.left_right += square(halves->left_right);
    out.top_bottom += square(halves->top_bottom);
    out.checkerboard += square(halves->checkerboard);
    out.position += square(position);
  }
  return out;
}

/// Mean of e C^-1 e' for levels of variance 1 that whole tiles share, from the tiles' responses one by one.
double expected(const RimModel& model, const std::function<bool(const Point&)>& in_half) {
  MatrixXd half = MatrixXd::Zero(4, 4);
  for (const TileSums& tile : model.tiles)
    if (in_half(tile.place)) half += tile.normal;
  const MatrixXd back = half * model.normal.inverse();
  const Eigen::Matrix2d spread = (half - back * half).topLeftCorner(2, 2);
  Eigen::Matrix2d seen = Eigen::Matrix2d::Zero();
  for (std::size_t t = 0; t < model.tiles.size(); ++t) {
    VectorXd response = VectorXd::Zero(4);
    for (const RimModel::Pixel& p : model.pixels)
      if (p.tile == t) response += p.weight * p.slope;
    const VectorXd moved = back * response;
    const Vector2d score =
        ((in_half(model.tiles[t].place) ? response : VectorXd(VectorXd::Zero(4))) - moved).head(2);
    seen += score * score.transpose();
  }
  return 0.5 * (spread.inverse() * seen).trace();
}

/// Of 2 x 3000 squares: one standard deviation is 0.018.
constexpr double kScatter = 0.06;

TEST(Halves, WhiteNoiseGivesTheCovarianceOfThePosition) {
  const Ratios r = simulate([](std::mt19937& random) {
    return [&](const RimModel::Pixel& p) {
      return std::normal_distribution<>(0, 1 / std::sqrt(p.weight))(random);
    };
  });
  EXPECT_NEAR(r.position, 1, kScatter);
  EXPECT_NEAR(r.left_right, 1, kScatter);
  EXPECT_NEAR(r.top_bottom, 1, kScatter);
  EXPECT_NEAR(r.checkerboard, 1, kScatter);
}

TEST(Halves, CovarianceIsThatOfThePositionAsAMatrix) {
  RimModel model;
  std::mt19937 random(5);
  Eigen::Matrix2d expected = Eigen::Matrix2d(MatrixXd(model.normal.inverse()).topLeftCorner<2, 2>());
  expected(0, 1) = expected(1, 0) = 0.6 * std::sqrt(expected(0, 0) * expected(1, 1));
  expected(1, 1) *= 3;  // any covariance that is asked for
  Eigen::Matrix2d seen = Eigen::Matrix2d::Zero();
  for (int k = 0; k < kFrames; ++k) {
    model.solve([&](const RimModel::Pixel& p) {
      return std::normal_distribution<>(0, 1 / std::sqrt(p.weight))(random);
    });
    const Vector2d e = halves_error(model.tiles, model.normal, expected)->left_right;
    seen += e * e.transpose() / kFrames;
  }
  EXPECT_NEAR(seen(0, 0) / expected(0, 0), 1, 0.1);
  EXPECT_NEAR(seen(1, 1) / expected(1, 1), 1, 0.1);
  EXPECT_NEAR(seen(0, 1) / expected(0, 1), 1, 0.15);
}

TEST(Halves, WithoutNuisancesItIsTheDifferenceOfTheHalvesPositions) {
  RimModel model;
  model.normal = model.normal.topLeftCorner(2, 2).eval();
  Eigen::Matrix2d left = Eigen::Matrix2d::Zero(), right = left;
  Vector2d left_force = Vector2d::Zero(), right_force = left_force;
  std::mt19937 random(6);
  std::normal_distribution<> noise;
  for (TileSums& tile : model.tiles) {
    tile.normal = tile.normal.topLeftCorner(2, 2).eval();
    const Vector2d force(noise(random), noise(random));
    (tile.place.x < 0 ? left : right) += tile.normal;
    (tile.place.x < 0 ? left_force : right_force) += force;
    tile.score = force;
  }
  const Vector2d found = model.normal.ldlt().solve(left_force + right_force);
  for (TileSums& tile : model.tiles) tile.score -= tile.normal * found;
  const Vector2d e = halves_of(model)->left_right;
  // e' C^-1 e = D' Cov(D)^-1 D for D the difference of two fits of their own.
  const Vector2d difference = left.inverse() * left_force - right.inverse() * right_force;
  const Eigen::Matrix2d of_difference = left.inverse() + right.inverse();
  EXPECT_NEAR(e.dot(Eigen::Matrix2d(model.normal) * e), difference.dot(of_difference.inverse() * difference),
              1e-9);
}

TEST(Halves, NoiseAlikeOverWholeTilesIsSeenAsThePositionFeelsIt) {
  const Ratios r = simulate([](std::mt19937& random) {
    std::vector<double> tiles(64);
    for (double& level : tiles) level = std::normal_distribution<>(0, 1)(random);
    return [tiles](const RimModel::Pixel& p) { return tiles[p.tile]; };
  });
  const RimModel model;
  EXPECT_GT(r.position, 4);
  EXPECT_NEAR(r.left_right / expected(model, [](const Point& p) { return p.x < 0; }), 1, kScatter);
  EXPECT_NEAR(r.top_bottom / expected(model, [](const Point& p) { return p.y < 0; }), 1, kScatter);
  // and that is the size of the position's own error.
  for (const double ratio : {r.left_right, r.top_bottom, r.checkerboard}) {
    EXPECT_GT(ratio, 0.5 * r.position);
    EXPECT_LT(ratio, 2 * r.position);
  }
}

TEST(Halves, ASlowWaveAcrossThePartShowsBetweenSidesAndNotBetweenTiles) {
  const Ratios r = simulate([](std::mt19937& random) {
    const double phase = std::uniform_real_distribution<>(0, 6.2831853)(random);
    const double angle = std::uniform_real_distribution<>(0, 6.2831853)(random);
    return [&random, phase, angle](const RimModel::Pixel& p) {
      const double wave = 3 * std::sin(phase + 0.1 * (std::cos(angle) * p.x + std::sin(angle) * p.y));
      return wave + std::normal_distribution<>(0, 1 / std::sqrt(p.weight))(random);
    };
  });
  EXPECT_GT(r.position, 10);
  EXPECT_GT(r.left_right, 0.3 * r.position);
  EXPECT_GT(r.top_bottom, 0.3 * r.position);
  EXPECT_LT(r.checkerboard, 0.1 * r.position);
  EXPECT_GT(r.checkerboard, 1);
}

TEST(Halves, AHalfWithoutInformationIsNoJudge) {
  RimModel model;
  model.solve([](const RimModel::Pixel&) { return 0.0; });
  std::erase_if(model.tiles, [](const TileSums& tile) { return tile.place.x < 0; });
  model.normal.setZero();
  for (const TileSums& tile : model.tiles) model.normal += tile.normal;
  EXPECT_FALSE(halves_of(model).has_value());
}

}  // namespace
}  // namespace tribotrack::vision
