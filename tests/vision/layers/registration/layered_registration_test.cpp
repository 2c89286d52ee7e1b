#include "vision/layers/registration/registration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vision/layered_scenes.h"
#include "vision/layers/learning/learning.h"

namespace tribotrack::vision {
namespace {

using test::SceneSource;
using test::SlidingScene;

/// Layers learnt from windows at their true places.
struct Learnt {
  SlidingScene scene;
  std::vector<KeptWindow> windows;
  GroundPicture ground;
  LayeredDisc disc;
  NoiseLaw noise;

  explicit Learnt(double spin)
      : scene(scene_of(spin)),
        ground({0, 0, scene.scene.width, scene.scene.height}),
        disc(scene.scene.disc.radius_px, 0.85, spin != 0) {
    SceneSource source(scene);
    const int reach = disc.half() + 6;
    Picture frame;
    for (int k = 0; k < scene.frames; k += 4) {
      const ScenePose pose = scene.pose(k);
      source.read(k, source.bounds(), frame);
      ground.add(frame, 0, 0, pose.platform, {pose.disc.x, pose.disc.y, disc.rim().outer()});
      const int x = static_cast<int>(pose.disc.x) - reach, y = static_cast<int>(pose.disc.y) - reach;
      KeptWindow w{Picture(2 * reach + 1, 2 * reach + 1),  x,  y,
                   {pose.disc, pose.theta, pose.platform}, {}, k};
      for (int j = 0; j < w.picture.height(); ++j)
        for (int i = 0; i < w.picture.width(); ++i) w.picture.at(i, j) = frame.at(x + i, y + j);
      w.spline = QuinticSpline(w.picture);
      windows.push_back(std::move(w));
    }
    const double variance = std::pow(scene.scene.read_noise, 2) + 1.0 / 12;
    ground.finish(variance);
    LayeredRegistration registration(disc, ground);
    LayeredLearning learning(disc, ground, registration, disc.radius(), {variance, 0});
    EXPECT_TRUE(learning.run(windows, windows));
    noise = learning.noise();
  }
  static SlidingScene scene_of(double spin) {
    SlidingScene s;
    s.frames = 120;
    s.scene.height = 130;
    s.spin_rad = spin;
    s.scene.disc.scratches = spin != 0 ? 12 : 0;
    return s;
  }
};

TEST(LayeredRegistration, EveryInstructionSetFindsTheSamePlace) {
  for (const double spin : {0.0, 0.2}) {
    SCOPED_TRACE(testing::Message() << "spin " << spin);
    const Learnt learnt(spin);
    const auto layers = all_layer_kernels();
    const auto tiles = all_tile_kernels();
    ASSERT_EQ(layers.size(), tiles.size());
    std::vector<std::vector<LayeredFix>> fixes;
    for (std::size_t set = 0; set < layers.size(); ++set) {
      SCOPED_TRACE(layers[set].name);
      LayeredRegistration registration(learnt.disc, learnt.ground, layers[set], tiles[set]);
      registration.set_noise(learnt.noise);
      registration.disc_changed(static_cast<int>(learnt.windows.size()));
      fixes.emplace_back();
      for (const KeptWindow& w : learnt.windows) {
        LayeredState start = w.state;
        start.centre.x += 0.05;
        const auto fix = registration.refine(w.picture, w.x, w.y, start);
        ASSERT_TRUE(fix.has_value());
        fixes.back().push_back(*fix);
      }
    }
    for (std::size_t set = 1; set < fixes.size(); ++set)
      for (std::size_t k = 0; k < fixes[0].size(); ++k) {
        const LayeredFix &slow = fixes[0][k], &fast = fixes[set][k];
        const double sd = std::sqrt(0.5 * slow.covariance.trace());
        // Sums of thousands of floats in another order; the iteration ends within 0.003 sd.
        EXPECT_NEAR(fast.state.centre.x, slow.state.centre.x, 0.01 * sd);
        EXPECT_NEAR(fast.state.centre.y, slow.state.centre.y, 0.01 * sd);
        EXPECT_NEAR(fast.state.theta, slow.state.theta, 1e-5);
        EXPECT_LT((fast.covariance - slow.covariance).norm(), 1e-3 * slow.covariance.norm());
        EXPECT_NEAR(fast.rim_chi_squared, slow.rim_chi_squared, 1e-3);
      }
  }
}

}  // namespace
}  // namespace tribotrack::vision
