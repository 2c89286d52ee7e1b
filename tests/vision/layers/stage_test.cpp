#include "vision/layers/layers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vision/layered_scenes.h"

namespace tribotrack::vision {
namespace {

using test::SceneSource;
using test::SlidingScene;
using test::TrackErrors;

TrackOptions with_marker(const SlidingScene& s) {
  TrackOptions options;
  options.marker.kind = MarkerChoice::Kind::circle;
  const MarkerAppearance& m = *s.scene.marker;
  options.marker.circle = {m.position.x + s.circle_px, m.position.y, m.radius_px};
  return options;
}

const PlanStage& stage(const TrackSummary& summary) {
  for (const PlanStage& s : summary.plan)
    if (s.name.starts_with("layers")) return s;
  throw std::logic_error("no stage 'layers' in the plan");
}

TEST(LayeredStage, BrushedPlatformIsTrackedNearTheBoundWithTrueErrors) {
  SlidingScene s;
  SceneSource source(s);
  const TrackResult result = track(source, with_marker(s));
  EXPECT_EQ(result.summary.ok, s.frames);
  EXPECT_TRUE(result.summary.layered);
  EXPECT_TRUE(stage(result.summary).on);
  EXPECT_TRUE(result.summary.warnings.empty());
  const TrackErrors e = errors_of(result.track, s);
  EXPECT_LT(e.rms, 1.3 * s.bound());
  EXPECT_GT(e.standardised, 0.9);
  EXPECT_LT(e.standardised, 1.15);
  EXPECT_LT(e.drift, 0.005);

  // What it is for.
  TrackOptions plain = with_marker(s);
  plain.layers = Layers::off;
  const TrackResult single = track(source, plain);
  EXPECT_FALSE(stage(single.summary).on);
  EXPECT_GT(errors_of(single.track, s).rms, 3 * e.rms);
}

TEST(LayeredStage, IsTheSameBitForBitForAnyNumberOfThreads) {
  SlidingScene s;
  s.frames = 150;
  s.scene.disc.scratches = 12;
  s.scene.disc.scratch_contrast = 12;
  s.spin_rad = 0.2;
  const auto tracked_by = [&](int threads) {
    SceneSource source(s);
    TrackOptions options = with_marker(s);
    options.threads = threads;
    return track(source, options);
  };
  const TrackResult one = tracked_by(1), three = tracked_by(3);
  ASSERT_TRUE(one.summary.layered);
  ASSERT_EQ(one.track.points.size(), three.track.points.size());
  for (std::size_t k = 0; k < one.track.points.size(); ++k) {
    const TrackPoint &a = one.track.points[k], &b = three.track.points[k];
    ASSERT_EQ(a.x, b.x) << k;
    ASSERT_EQ(a.y, b.y) << k;
    ASSERT_EQ(a.sigma_x, b.sigma_x) << k;
    ASSERT_EQ(a.rho_xy, b.rho_xy) << k;
  }
  EXPECT_EQ(stage(one.summary).reason, stage(three.summary).reason);
}

// On even ground, on which a single template explains the disc, pictures learnt would add their own noise.
TEST(LayeredStage, IsLeftOutWhereThereIsNothingToLearn) {
  SlidingScene s;
  s.scene.platform.texture_rms = 0;
  s.scene.disc.scratches = 0;
  s.scene.disc.highlight = 0;
  SceneSource source(s);
  const TrackResult result = track(source, with_marker(s));
  EXPECT_FALSE(result.summary.layered);
  const PlanStage& left_out = stage(result.summary);
  EXPECT_FALSE(left_out.on);
  EXPECT_TRUE(left_out.reason.starts_with("nothing to learn")) << left_out.reason;
  ASSERT_TRUE(left_out.error_bound_px);
  EXPECT_LT(*left_out.error_bound_px, s.bound());
  const TrackErrors e = errors_of(result.track, s);
  EXPECT_LT(e.rms, 1.1 * s.bound());
  // Asked for, it is tried.
  TrackOptions asked = with_marker(s);
  asked.layers = Layers::on;
  EXPECT_FALSE(stage(track(source, asked).summary).reason.starts_with("nothing to learn"));
}

TEST(LayeredStage, VignettingSpinAndHighlightLeaveNoDrift) {
  SlidingScene s;
  s.scene.disc.scratches = 12;
  s.scene.disc.scratch_contrast = 12;
  s.spin_rad = 0.2;
  s.scene.vignetting = 0.08;
  s.scene.disc.highlight = 25;
  s.scene.shot_noise = 0.01;
  SceneSource source(s);
  const TrackResult result = track(source, with_marker(s));
  EXPECT_TRUE(result.summary.layered);
  const TrackErrors e = errors_of(result.track, s);
  EXPECT_LT(e.rms, 1.3 * s.bound());
  EXPECT_LT(e.drift, 0.005);
  EXPECT_GT(e.standardised, 0.9);
  EXPECT_LT(e.standardised, 1.1);
  EXPECT_NEAR(result.summary.disc.radius, 30, 0.01);
}

TEST(LayeredStage, RestingPlatformNeedsNoMarker) {
  SlidingScene s;
  s.circle_px = 0;
  s.scene.marker.reset();
  SceneSource source(s);
  const TrackResult result = track(source, {});
  EXPECT_TRUE(result.summary.layered);
  const TrackErrors e = errors_of(result.track, s);
  EXPECT_LT(e.rms, 1.15 * s.bound());
  EXPECT_LT(e.drift, 0.005);
}

// Where the ground shows no texture, alpha and the light cannot be told apart window by window: nothing may
// run away, however few the frames. The rms of n components scatters by 1 / sqrt(2 n).
TEST(LayeredStage, PlainPlatformIsAtTheBound) {
  for (const int frames : {24, 100, 240}) {
    SCOPED_TRACE(frames);
    SlidingScene s;
    s.frames = frames;
    s.scene.platform.texture_rms = 0;
    SceneSource source(s);
    TrackOptions options = with_marker(s);
    options.layers = Layers::on;
    const TrackResult result = track(source, options);
    const TrackErrors e = errors_of(result.track, s);
    const double scatter = 2 / std::sqrt(4.0 * frames);
    EXPECT_LT(e.rms, (1.04 + scatter) * s.bound());
    EXPECT_GT(e.standardised, 0.97 - scatter);
    EXPECT_LT(e.standardised, 1.04 + scatter);
  }
}

}  // namespace
}  // namespace tribotrack::vision
