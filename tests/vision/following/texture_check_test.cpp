// What a coder leaves in the first frame is not taken for the part's texture; scratches are.
#include "vision/following/template_average.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "apps/bench/vision.h"
#include "vision/scene.h"

namespace tribotrack::vision {
namespace {

constexpr double kRadius = 24;
constexpr int kFrames = 20;

/// A disc that drifts and turns, exact.
std::vector<Picture> drifting(int scratches, double highlight, double spin) {
  Scene s;
  s.width = s.height = 101;
  s.disc.radius_px = kRadius;
  s.disc.scratches = scratches;
  s.disc.highlight = highlight;
  s.platform.texture_rms = 0;
  const SceneRenderer renderer(s);
  std::vector<Picture> frames;
  for (int k = 0; k < kFrames; ++k) {
    ScenePose p;
    p.disc = {50 + 0.37 * k, 50 - 0.23 * k};
    p.theta = spin * k;
    frames.push_back(renderer.render_exact(0, 0, [p](double) { return p; }));
  }
  return frames;
}

bool returns(const std::vector<Picture>& exact, double noise, double noise_said) {
  std::vector<Picture> frames;
  for (std::size_t k = 0; k < exact.size(); ++k) frames.push_back(bench::recorded(exact[k], noise, k));
  MemorySource source(frames, bench::kFrameRate);
  FollowOptions follow;
  follow.noise_variance = noise_said * noise_said + 1.0 / 12;
  const Pattern disc = disc_pattern(frames.front(), {50, 50, kRadius});
  return texture_returns(source, frames.front(), 0, kFrames - 1, disc, follow);
}

TEST(TextureCheck, MarksThatAreAnewInEveryFrameAreNoTexture) {
  // As a coder leaves them: what differs between frames elsewhere says that there is hardly any noise.
  EXPECT_FALSE(returns(drifting(0, 0, 0), 2, 0.2));
}

TEST(TextureCheck, ScratchesComeAgainWhetherTheDiscTurnsOrNot) {
  for (const double spin : {0.0, 0.05}) EXPECT_TRUE(returns(drifting(8, 0, spin), 2, 2)) << spin;
}

TEST(TextureCheck, AReflectionThatStandsStillIsLeftToTheLayersToTell) {
  EXPECT_TRUE(returns(drifting(0, 60, 0.05), 1, 1));
}

TEST(TextureCheck, TooFewFramesSayNothing) {
  std::vector<Picture> frames = drifting(0, 0, 0);
  frames.resize(5);
  std::vector<Picture> noisy;
  for (std::size_t k = 0; k < frames.size(); ++k) noisy.push_back(bench::recorded(frames[k], 2, k));
  MemorySource source(noisy, bench::kFrameRate);
  FollowOptions follow;
  follow.noise_variance = 0.1;
  EXPECT_TRUE(
      texture_returns(source, noisy.front(), 0, 4, disc_pattern(noisy.front(), {50, 50, kRadius}), follow));
}

}  // namespace
}  // namespace tribotrack::vision
