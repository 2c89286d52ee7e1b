// What the tiles of a registered template say for the audit.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "vision/analytic_scene.h"
#include "vision/registration/registration.h"

namespace tribotrack::vision {
namespace {

using test::TestScene;

constexpr double kSigma = 2;

TestScene scene_at(double x, double y) {
  TestScene scene;
  scene.width = scene.height = 56;
  scene.discs = {{x, y, 14, 0, scene.ground + 90, {}}};
  return scene;
}

TemplateRegistration registration_of(const Picture& first, bool rotation = false) {
  RegistrationOptions options;
  options.noise_variance = kSigma * kSigma + 1.0 / 12;
  options.template_noise_share = 0;
  options.rotation = rotation;
  return TemplateRegistration(first, disc_pattern(first, {28, 28, 14}), options);
}

struct Whole {
  TileSums::Vector score;
  TileSums::Matrix normal;
};

Whole sum(const std::vector<TileSums>& tiles) {
  Whole out{tiles.front().score, tiles.front().normal};
  for (std::size_t t = 1; t < tiles.size(); ++t) {
    out.score += tiles[t].score;
    out.normal += tiles[t].normal;
  }
  return out;
}

TEST(TileSums, ScoresAddUpToNothingAndNormalsToTheCovariance) {
  std::mt19937 random(3);
  for (const bool rotation : {false, true}) {
    TemplateRegistration registration = registration_of(scene_at(28, 28).render(), rotation);
    Picture picture = test::noisy(scene_at(28.3, 27.8).render(), kSigma, random);
    for (float& level : picture.levels()) level = 0.5F * level + 20;  // a light of its own
    const Registration r = registration.refine(picture, 0, 0, {});
    ASSERT_TRUE(r.converged);
    const std::vector<TileSums> tiles = registration.tile_sums();
    const Whole whole = sum(tiles);
    ASSERT_EQ(whole.score.size(), rotation ? 5 : 4);
    const TileSums::Matrix inverse = whole.normal.inverse();
    // The optimum: a step from here is a small part of the standard deviation.
    EXPECT_LT((inverse * whole.score).head<2>().norm(), 0.02 * std::sqrt(inverse(0, 0)));
    const Eigen::Matrix2d covariance = inverse.topLeftCorner<2, 2>();
    EXPECT_LT((covariance - registration.model_covariance()).norm(), 1e-3 * covariance.norm());
    for (const TileSums& tile : tiles) EXPECT_LT(std::hypot(tile.place.x, tile.place.y), 14 + 8 + 6);
  }
}

TEST(TileSums, KernelsOfEveryTileAddUpToTheWhole) {
  std::mt19937 random(5);
  std::normal_distribution<float> number;
  for (const bool turns : {false, true})
    for (const TileKernels& kernels : all_tile_kernels()) {
      TileArrays arrays;
      arrays.tiles = 3;
      for (auto* v : {&arrays.value, &arrays.slope_x, &arrays.slope_y, &arrays.level, &arrays.weight})
        for (std::size_t k = 0; k < 3 * kTilePixels; ++k) v->push_back(std::abs(number(random)));
      if (turns) arrays.slope_theta = arrays.level;
      std::vector<NormalSums> tiles(3);
      kernels.normals(arrays, tiles);
      const NormalSums whole = kernels.normal(arrays);
      for (std::size_t k = 0; k < whole.size(); ++k)
        EXPECT_NEAR(tiles[0][k] + tiles[1][k] + tiles[2][k], whole[k], 1e-4 * (1 + std::abs(whole[k])))
            << kernels.name;
    }
}

}  // namespace
}  // namespace tribotrack::vision
