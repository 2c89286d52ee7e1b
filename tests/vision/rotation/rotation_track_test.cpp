// The rotation of rendered discs against the renderer's own.
#include "vision/rotation/rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "vision/analytic_scene.h"
#include "vision/scene.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

using test::RenderedSource;

constexpr double kFps = 500;

struct Spinning {
  Scene scene;
  int frames = 60;
  std::function<double(double frame)> theta;
  std::function<Point(double frame)> centre = [](double k) { return Point{50.3 + 0.31 * k, 48.7 - 0.1 * k}; };

  Spinning() {
    scene.width = 120;
    scene.height = 100;
    scene.disc.radius_px = 22;
    scene.disc.scratches = 30;
    scene.disc.highlight = 0;
    scene.platform.texture_rms = 4;
    scene.read_noise = 2;
    scene.seed = 11;
  }
  RenderedSource source() const {
    const auto renderer = std::make_shared<SceneRenderer>(scene);
    return RenderedSource(scene.width, scene.height, frames, [this, renderer](std::int64_t k) {
      const auto at = [&](double t) { return ScenePose{centre(t * kFps), theta(t * kFps), {0, 0}}; };
      return renderer->render(static_cast<int>(k), static_cast<double>(k) / kFps, 0, at, 1);
    });
  }
  SeenFrames placed() const {
    SeenFrames out;
    for (int k = 0; k < frames; ++k) out.push_back({k, centre(k)});
    return out;
  }
};

/// Rms of the error over what is told, all relative to the first frame.
double standardised(const Spinning& s, const std::vector<std::optional<Rotation>>& seen) {
  double square = 0;
  int count = 0;
  for (std::size_t k = 1; k < seen.size(); ++k)
    if (seen[k]) {
      const double truth = s.theta(static_cast<double>(k)) - s.theta(0);
      square += std::pow((seen[k]->theta - truth) / seen[k]->sigma, 2);
      ++count;
    }
  EXPECT_EQ(count, s.frames - 1);
  return std::sqrt(square / count);
}

TEST(RotationTrack, FollowsASpinThroughSeveralTurnsToItsSd) {
  for (const double rate : {0.23, -0.05, 0.004}) {
    Spinning s;
    s.theta = [rate](double k) { return 0.4 + rate * k; };
    RenderedSource source = s.source();
    const auto seen = follow_rotation(source, s.placed(), 22, 0.8);
    ASSERT_EQ(seen.size(), 60U);
    const double ratio = standardised(s, seen);
    EXPECT_LT(ratio, 2);
    EXPECT_GT(ratio, 0.2);
    EXPECT_LT(seen.back()->sigma, 0.03);
  }
}

/// Their rings are made of pixels of 2 x 2 and 3 x 3.
TEST(RotationTrack, OfLargeDiscsIsAboutTheSameCentre) {
  for (const double radius : {70.0, 100.0}) {
    Spinning s;
    s.frames = 10;
    s.scene.disc.radius_px = radius;
    s.scene.width = s.scene.height = static_cast<int>(2 * radius) + 40;
    s.centre = [radius](double k) { return Point{radius + 14.3 + 0.31 * k, radius + 13.6 - 0.1 * k}; };
    s.theta = [](double k) { return 0.2 * k; };
    RenderedSource source = s.source();
    const auto seen = follow_rotation(source, s.placed(), radius, 0.8);
    ASSERT_EQ(seen.size(), 10U);
    EXPECT_LT(standardised(s, seen), 2) << radius;
    EXPECT_LT(seen.back()->sigma, 0.01) << radius;
  }
}

TEST(RotationTrack, ScattersFromFrameToFrameAsItsSdSays) {
  Spinning s;
  s.frames = 200;
  // Fractions of a pixel that have nothing to do with those of the frame before.
  s.centre = [](double k) { return Point{55.3 + 5 * std::sin(1.7 * k), 48.7 + 4 * std::cos(2.3 * k)}; };
  s.theta = [](double) { return 0.4; };
  RenderedSource source = s.source();
  const auto seen = follow_rotation(source, s.placed(), 22, 0.8);
  double square = 0, variance = 0;
  for (std::size_t k = 2; k < seen.size(); ++k) {
    ASSERT_TRUE(seen[k] && seen[k - 1]);
    square += 0.5 * std::pow(seen[k]->theta - seen[k - 1]->theta, 2);
    variance += std::pow(seen[k]->sigma, 2);
  }
  EXPECT_LT(std::sqrt(square / variance), 1.2);
  EXPECT_GT(std::sqrt(square / variance), 0.7);
}

TEST(RotationTrack, StandsInTheTrackWhereATextureShowsIt) {
  for (const int scratches : {30, 0}) {
    Spinning s;
    s.scene.disc.scratches = scratches;
    s.theta = [](double k) { return -0.03 * k; };
    RenderedSource source = s.source();
    TrackOptions options;
    options.target = {Target::Kind::disc, {50.3, 48.7, 22}, {}};
    options.layers = Layers::off;
    const Track track = vision::track(source, options).track;
    EXPECT_EQ(track.has_rotation, scratches > 0);
    EXPECT_EQ(track.points.back().rotation.has_value(), scratches > 0);
    if (scratches > 0) {
      EXPECT_NEAR(track.points.back().rotation->theta, -0.03 * 59, 0.03);
    }
  }
}

}  // namespace
}  // namespace tribotrack::vision
