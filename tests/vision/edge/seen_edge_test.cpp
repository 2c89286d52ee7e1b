#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vision/edge/radius.h"
#include "vision/layered_scenes.h"

namespace tribotrack::vision {
namespace {

/// The edge as seen in `count` frames, with the disc at its true places.
template <class Place>
std::optional<DiscFit> seen_in(FrameSource& source, int count, double radius, const Place& place) {
  SeenFrames frames;
  for (int k = 0; k < count; ++k) frames.push_back({k, place(k), {}});
  return seen_edge(source, frames, radius);
}

struct SlidingDisc {
  static constexpr int kFrames = 60;
  Scene scene;
  double speed;

  SlidingDisc(double radius, double first_speed, std::uint64_t seed) : speed(first_speed) {
    scene.width = 210;
    scene.height = 60;
    scene.seed = seed;
    scene.platform.level = 20;
    scene.platform.texture_rms = 0;
    scene.disc.radius_px = radius;
    scene.disc.scratches = 0;
    scene.disc.highlight = 0;
    scene.disc.edge_blur_px = 0.5;
  }
  /// Slower and slower: at rest in the last frame. t in frames.
  ScenePose pose(double t) const {
    return {{30.3 + speed * (t - t * t / (2 * kFrames)), 30.2 + 0.1 * speed * t}, 0, {0, 0}};
  }
  std::vector<Picture> smeared() const {
    const SceneRenderer renderer(scene);
    std::vector<Picture> pictures;
    for (int k = 0; k < kFrames; ++k) {
      pictures.push_back(renderer.render_exact(k, 1, [&](double t) { return pose(t); }));
      std::mt19937 random(static_cast<unsigned>(scene.seed) * 1000 + static_cast<unsigned>(k));
      std::normal_distribution<double> noise(0, 1.2);
      for (float& level : pictures.back().levels())
        level = static_cast<float>(std::round(level + noise(random)));
    }
    return pictures;
  }
};

// A disc that stays over one place of a textured platform: all frames see the same ground beyond the rim. The
// sd is that of few independent stretches of the rim, its square is right on average.
TEST(SeenEdge, KnowsWhatTheGroundBeyondTheRimDoes) {
  double sum = 0, squares = 0, variance = 0;
  constexpr int kCount = 50;
  for (int k = 0; k < kCount; ++k) {
    test::SlidingScene s;
    s.frames = 30;
    s.path_px = 0;
    s.scene.width = 150;
    s.scene.seed = static_cast<std::uint64_t>(100 + k);
    s.scene.disc.radius_px = 11.3 + 0.013 * k;
    test::SceneSource source(s);
    const auto mean = seen_in(source, s.frames, s.scene.disc.radius_px, [&](int n) { return s.truth(n); });
    ASSERT_TRUE(mean);
    const double error = mean->circle.radius - s.scene.disc.radius_px;
    sum += error / kCount;
    squares += error * error / kCount;
    variance += mean->radius_sd * mean->radius_sd / kCount;
  }
  const double ratio = std::sqrt(squares / variance);
  EXPECT_GT(ratio, 0.5);
  EXPECT_LT(ratio, 1.45);
}

/// A disc that comes to rest under a shutter that is always open.
TEST(SeenEdge, HoldsUnderMotionBlur) {
  constexpr double kSpeed = 1.5;  // px a frame, at first
  double squares = 0;
  int count = 0;
  for (const double radius : {8.7, 15.3}) {
    const SlidingDisc disc(radius, kSpeed, static_cast<std::uint64_t>(10 + count));
    MemorySource source(disc.smeared(), 250);
    const auto mean = seen_in(source, SlidingDisc::kFrames, radius, [&](int k) { return disc.pose(k).disc; });
    ASSERT_TRUE(mean);
    squares += std::pow((mean->circle.radius - radius) / mean->radius_sd, 2);
    EXPECT_LT(std::abs(mean->circle.radius - radius) / radius, 0.002);
    ++count;
  }
  EXPECT_LT(std::sqrt(squares / count), 2.2);
}

}  // namespace
}  // namespace tribotrack::vision
