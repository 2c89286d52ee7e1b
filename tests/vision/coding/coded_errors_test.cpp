// Coded recordings of a scene that is known exactly: what the track says of its errors.
#include "vision/coding/coded_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "vision/recordings.h"
#include "vision/scene.h"
#include "vision/track_errors.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

constexpr int kFrames = 160, kPeriod = 40;  ///< frames in a turn
constexpr double kSlow = 0.3, kFast = 5;    ///< px: a coder predicts from the same place, or by vectors

class CodedTrackTest : public RecordingTest {
 protected:
  double amplitude_ = kSlow;

  Point truth(int k) const {
    const double phase = 2 * std::numbers::pi * k / kPeriod;
    return {56.3 + amplitude_ * std::cos(phase), 55.6 + amplitude_ * std::sin(phase)};
  }

  std::filesystem::path coded(const char* name, SinkOptions sink, int scratches = 0) {
    Scene scene;
    scene.width = scene.height = 112;
    scene.disc = {.radius_px = 24,
                  .level = 160,
                  .edge_blur_px = 0.7,
                  .scratches = scratches,
                  .scratch_contrast = 12,
                  .highlight = 0};
    scene.platform = {.level = 60, .texture_rms = 0};
    const SceneRenderer renderer(scene);
    sink.width = sink.height = 112;
    sink.frame_rate_hz = 30;
    const auto writer = create_sink(file(name), sink);
    for (int k = 0; k < kFrames; ++k)
      writer->write(renderer.render(k, k, 0, [&](double) { return ScenePose{truth(k), 0, {}}; }));
    writer->close();
    return file(name);
  }

  test::TrackErrors compare(const Track& track) const {
    const test::TrackErrors e =
        test::errors_of(track, [this](std::int64_t k) { return truth(static_cast<int>(k)); });
    EXPECT_EQ(e.count, kFrames);
    return e;
  }

  static TrackOptions options() {
    TrackOptions out;
    out.target = {Target::Kind::disc, {56, 56, 24}, {}};
    out.marker.kind = MarkerChoice::Kind::none;
    return out;
  }
};

/// The part moves by 0.05 and by 0.8 px a frame.
TEST_F(CodedTrackTest, ErrorsThroughH264AreThoseStated) {
  struct Case {
    double amplitude, still_above, still_below, moving_above;
  };
  for (const Case& c : {Case{kSlow, 0.5, 1, -1}, Case{kFast, -1, 0.1, 0.9}}) {
    SCOPED_TRACE(c.amplitude);
    amplitude_ = c.amplitude;
    TrackOptions o = options();
    o.target.disc.x = truth(0).x;
    const auto source =
        open_source(coded("a.mp4", {.codec = Codec::h264, .crf = 23}), {.frame_rate_hz = 1000});
    const TrackResult result = track(*source, o);
    ASSERT_TRUE(result.summary.coded);
    EXPECT_GT(result.summary.coded->still, c.still_above);
    EXPECT_LE(result.summary.coded->still, c.still_below);
    EXPECT_GT(result.summary.coded->moving, c.moving_above);
    const test::TrackErrors seen = compare(result.track);
    if (c.amplitude == kSlow) {
      EXPECT_GT(seen.rms, 0.02) << "the coder must do harm for this test to mean anything";
    }
    EXPECT_GT(seen.rms / seen.sd, 0.5);
    EXPECT_LT(seen.rms / seen.sd, 1.5);
  }
}

TEST_F(CodedTrackTest, WhatIsLearntFromGroundThatLagsIsNotBelieved) {
  Scene scene;
  scene.width = scene.height = 176;
  scene.disc = {.radius_px = 30, .level = 170, .edge_blur_px = 0.8, .scratches = 12, .scratch_contrast = 12};
  scene.platform = {.level = 70, .texture_rms = 6, .brush_angle_rad = 0.3};
  const auto pose_of = [](int k) {
    const double turn = 2 * std::numbers::pi * k / 25;
    const Point platform{2.8 * std::cos(turn), 2.8 * std::sin(turn)};
    return ScenePose{{90 - 0.02 * k + 0.8 * platform.x, 87 + 0.8 * platform.y}, 0, platform};
  };
  const SceneRenderer renderer(scene);
  const auto writer = create_sink(
      file("ground.mp4"),
      {.width = scene.width, .height = scene.height, .frame_rate_hz = 30, .codec = Codec::h264, .crf = 23});
  for (int k = 0; k < kFrames; ++k)
    writer->write(renderer.render(k, k, 0, [&](double) { return pose_of(k); }));
  writer->close();
  const auto errors = [&](Layers layers) {
    TrackOptions options;
    options.target = {Target::Kind::disc, {92.2, 87, 30}, {}};
    options.marker.kind = MarkerChoice::Kind::none;
    options.layers = layers;
    const auto source = open_source(file("ground.mp4"), {.frame_rate_hz = 1000});
    return test::errors_of(track(*source, options).track,
                           [&](std::int64_t k) { return pose_of(static_cast<int>(k)).disc; });
  };
  const test::TrackErrors by_template = errors(Layers::off), chosen = errors(Layers::automatic);
  EXPECT_LT(chosen.rms, 1.1 * by_template.rms);
  EXPECT_LT(chosen.rms / chosen.sd, 1.3);
}

TEST_F(CodedTrackTest, FramesByThemselvesComeNeitherLateNorSmall) {
  const auto source = open_source(coded("intra.avi", {.codec = Codec::mjpeg}), {.frame_rate_hz = 1000});
  const TrackResult result = track(*source, options());
  ASSERT_TRUE(result.summary.coded);
  EXPECT_EQ(result.summary.coded->part_play, 0);
  const test::TrackErrors seen = compare(result.track);
  EXPECT_GT(seen.rms / seen.sd, 0.75);
  EXPECT_LT(seen.rms / seen.sd, 1.3);
}

// Cells of the codec, which the part moves over, turn what is seen of its scratches to and fro. Its edge,
// which they move as well, is no better for that.
TEST_F(CodedTrackTest, APartThatOnlySeemsToTurnKeepsItsPictures) {
  amplitude_ = kFast;
  const auto source = open_source(coded("fine.mp4", {.crf = 30}, 60), {.frame_rate_hz = 1000});
  TrackOptions there = options();
  there.target = {Target::Kind::disc, {truth(0).x, truth(0).y, 24}, {}};
  const TrackResult result = track(*source, there);
  const auto edge = std::ranges::find(result.summary.plan, "edge in bands of time", &PlanStage::name);
  ASSERT_NE(edge, result.summary.plan.end());
  EXPECT_FALSE(edge->on);
  EXPECT_NE(edge->reason.find("does not turn visibly"), std::string::npos) << edge->reason;
}

TEST(UnknownCoder, AllErrorsMayBeItsPlayWhoeverCountedThem) {
  Track track;
  for (int k = 0; k < 40; ++k) {
    TrackPoint& p = track.points.emplace_back();
    p.status = TrackStatus::ok;
    p.x = std::cos(0.3 * k);
    p.y = std::sin(0.3 * k);
    p.sigma_x = p.sigma_y = 0.04;
  }
  TrackSummary summary;
  summary.layered = true;
  summary.audit.white_factor = 100;  // more than the law of such coders
  CodedTrack coded;
  for (int k = 0; k < 40; ++k) coded.frames.push_back({.index = k, .part = {}, .mark = {}});
  widen_for_coding(coded, track, summary);
  EXPECT_EQ(summary.coded->added_sd, 0);
  EXPECT_NEAR(summary.coded->mark_play, 0.04 * std::numbers::sqrt2, 1e-12);
  coded.coder.all_intra = true;
  widen_for_coding(coded, track, summary);
  EXPECT_EQ(summary.coded->mark_play, 0) << "nothing is predicted";
}

TEST(PlatformTexture, IsLeftOutWhereTheStepsHideIt) {
  for (const auto& [step, seen] : {std::pair(9.0, true), std::pair(11.0, false)}) {
    Track track;
    track.has_marker = true;
    track.points.resize(1);
    track.points[0].marker.emplace();
    TrackSummary summary;
    summary.ground_steps = 10;
    summary.plan = {{.name = "marker", .on = true, .reason = ""}};
    CodedTrack coded;
    coded.coder.all_intra = true;
    coded.frames = {{.index = 0, .part = {}, .mark = {.step = step}}};
    widen_for_coding(coded, track, summary);
    EXPECT_EQ(track.has_marker, seen) << step;
    EXPECT_EQ(track.points[0].marker.has_value(), seen) << step;
    EXPECT_EQ(summary.plan[0].on, seen) << step;
    EXPECT_EQ(summary.warnings.empty(), seen) << step;
  }
}

TEST(Forecast, GrowsWithTheStepAndFallsWithTheContrast) {
  Coder coder;
  coder.step = 10;
  const auto once = forecast(coder, 100), twice = forecast(coder, 50);
  ASSERT_TRUE(once && twice);
  EXPECT_DOUBLE_EQ(twice->error_px, 2 * once->error_px);
  EXPECT_DOUBLE_EQ(once->late_px, 0.83 * 0.1 / std::numbers::sqrt2);
  coder.all_intra = true;
  EXPECT_LT(forecast(coder, 100)->error_px, once->error_px);
  EXPECT_EQ(forecast(coder, 100)->late_px, 0);
  coder.step = 0;
  EXPECT_FALSE(forecast(coder, 100));
}

}  // namespace
}  // namespace tribotrack::vision
