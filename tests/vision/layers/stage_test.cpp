#include "vision/layers/stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

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

TrackErrors report(const char* name, const TrackResult& result, const SlidingScene& s, double bound) {
  const TrackErrors e = errors_of(result.track, s);
  std::printf("%s: rms %.5f px, %.3f x bound, standardised %.3f, drift %.5f px\n", name, e.rms, e.rms / bound,
              e.standardised, e.drift);
  return e;
}

class BrushedPlatform : public testing::TestWithParam<double> {};

TEST_P(BrushedPlatform, IsTrackedNearTheBoundWithTrueErrors) {
  SlidingScene s;
  s.scene.platform.texture_rms = GetParam();
  SceneSource source(s);
  const TrackResult result = track(source, with_marker(s));
  EXPECT_EQ(result.summary.ok, s.frames);
  EXPECT_TRUE(result.summary.layered);
  EXPECT_TRUE(stage(result.summary).on);
  EXPECT_TRUE(result.summary.warnings.empty());
  const TrackErrors e = report("brushed", result, s, s.bound());
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
INSTANTIATE_TEST_SUITE_P(TextureGreyLevels, BrushedPlatform, testing::Values(6.0));

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
  const TrackErrors e = report("nothing to learn", result, s, s.bound());
  EXPECT_LT(e.rms, 1.1 * s.bound());
  // Asked for, it is tried.
  TrackOptions asked = with_marker(s);
  asked.layers = Layers::on;
  EXPECT_FALSE(stage(track(source, asked).summary).reason.starts_with("nothing to learn"));
}

/// What the light and the part do to a recording, and what that may cost.
struct Hardship {
  const char* name;
  void (*change)(SlidingScene&);
  double rms, drift;  ///< at most: bounds, px
  double least_standardised, most_standardised;
};

TrackSummary expect_borne(const Hardship& hardship) {
  SCOPED_TRACE(hardship.name);
  SlidingScene s;
  hardship.change(s);
  SceneSource source(s);
  const TrackResult result = track(source, with_marker(s));
  EXPECT_TRUE(result.summary.layered);
  const TrackErrors e = report(hardship.name, result, s, s.bound());
  EXPECT_LT(e.rms, hardship.rms * s.bound());
  EXPECT_LT(e.drift, hardship.drift);
  EXPECT_GT(e.standardised, hardship.least_standardised);
  EXPECT_LT(e.standardised, hardship.most_standardised);
  return result.summary;
}

void scratched_and_turning(SlidingScene& s) {
  s.scene.disc.scratches = 12;
  s.scene.disc.scratch_contrast = 12;
  s.spin_rad = 0.2;
}

TEST(LayeredStage, VignettingSpinAndHighlightLeaveNoDrift) {
  const TrackSummary summary = expect_borne({"all together",
                                             [](SlidingScene& s) {
                                               scratched_and_turning(s);
                                               s.scene.vignetting = 0.08;
                                               s.scene.disc.highlight = 25;
                                               s.scene.shot_noise = 0.01;
                                             },
                                             1.3, 0.005, 0.9, 1.1});
  EXPECT_NEAR(summary.disc.radius, 30, 0.01);
}

TEST(LayeredStageCampaign, DISABLED_LightAndScratchesDrawNothing) {
  expect_borne({"highlight on a disc that does not turn",
                [](SlidingScene& s) { s.scene.disc.highlight = 25; }, 1.15, 0.005, 0.9, 1.1});
  expect_borne({"scratches that turn in noise",
                [](SlidingScene& s) {
                  scratched_and_turning(s);
                  s.scene.platform.texture_rms = 10;
                  s.scene.read_noise = 2;
                },
                1.15, 0.005, 0.85, 1.15});
  // The light's slope over the disc changes along the path, which no frame by itself sees well: taken for one
  // and the same everywhere it draws the disc by 0.03 px. On so short a path a strip of the ground is never
  // uncovered, and is not told from the light on it.
  expect_borne({"vignetting along a short path",
                [](SlidingScene& s) {
                  s.frames = 600;
                  s.path_px = 70;
                  s.scene.vignetting = 0.02;
                  s.scene.platform.texture_rms = 10;
                  s.scene.read_noise = 2;
                },
                1.15, 0.01, 0.85, 1.15});
}

TEST(LayeredStage, RestingPlatformNeedsNoMarker) {
  SlidingScene s;
  s.circle_px = 0;
  s.scene.marker.reset();
  SceneSource source(s);
  const TrackResult result = track(source, {});
  EXPECT_TRUE(result.summary.layered);
  const TrackErrors e = report("at rest", result, s, s.bound());
  EXPECT_LT(e.rms, 1.15 * s.bound());
  EXPECT_LT(e.drift, 0.005);
}

// The ground then stands in what the pictures leave unexplained: wider, and said so.
TEST(LayeredStageCampaign, DISABLED_MovingGroundThatNobodyFollowsWidensTheStandardDeviations) {
  SlidingScene s;
  s.scene.marker.reset();
  SceneSource source(s);
  TrackOptions options;
  options.marker.kind = MarkerChoice::Kind::none;
  const TrackResult result = track(source, options);
  EXPECT_TRUE(result.summary.layered);
  const TrackErrors e = report("not followed", result, s, s.bound());
  EXPECT_GT(e.rms, 1.5 * s.bound());
  EXPECT_GT(e.standardised, 0.8);
  EXPECT_LT(e.standardised, 1.2);
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
    const TrackErrors e = report("plain", result, s, s.bound());
    const double scatter = 2 / std::sqrt(4.0 * frames);
    EXPECT_LT(e.rms, (1.04 + scatter) * s.bound());
    EXPECT_GT(e.standardised, 0.97 - scatter);
    EXPECT_LT(e.standardised, 1.04 + scatter);
  }
}

TEST(LayeredStage, RecordingIsReadABoundedNumberOfTimes) {
  SlidingScene s;
  s.frames = 60;
  SceneSource source(s);
  TrackOptions options = with_marker(s);
  options.layers = Layers::off;
  track(source, options);
  const std::int64_t first_pass = source.reads();
  options.layers = Layers::on;
  track(source, options);
  // Thrice by the pictures, eight times by the edge.
  EXPECT_LE(source.reads() - first_pass, first_pass + 11 * s.frames);
}

}  // namespace
}  // namespace tribotrack::vision
