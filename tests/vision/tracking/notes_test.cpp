// The plan is honest: an error bound only where somebody computed it, 0 only where leaving out is exact.
#include "vision/tracking/setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "vision/layered_scenes.h"

namespace tribotrack::vision {
namespace {

const PlanStage& stage(const TrackSummary& summary, const std::string& name) {
  for (const PlanStage& s : summary.plan)
    if (s.name.starts_with(name)) return s;
  throw std::logic_error("no stage " + name);
}

TEST(PlanNotes, SwitchedOffLayersDoNotClaimThatTheyWouldAddNothing) {
  test::SlidingScene scene;
  scene.frames = 40;
  test::SceneSource source(scene);
  TrackOptions options;
  options.layers = Layers::off;
  const TrackSummary summary = track(source, options).summary;
  EXPECT_FALSE(stage(summary, "layers").on);
  EXPECT_FALSE(stage(summary, "layers").error_bound_px);  // the background is brushed: it costs 0.03 px
  for (const PlanStage& s : summary.plan)
    EXPECT_TRUE(!s.error_bound_px || *s.error_bound_px > 0 || s.name == "bad pixels") << s.name;
}

TEST(FrameCounts, LostBeforeItLeftForGoodCount) {
  Track track;
  const auto add_points = [&](TrackStatus status, int times) {
    for (int k = 0; k < times; ++k) track.points.emplace_back().status = status;
  };
  add_points(TrackStatus::ok, 10);
  add_points(TrackStatus::lost, 2);
  add_points(TrackStatus::ok, 8);
  add_points(TrackStatus::edge, 3);
  add_points(TrackStatus::lost, 17);
  const FrameCounts counts = count(track, 0.05);
  EXPECT_EQ(counts.frames, 40);
  EXPECT_EQ(counts.ok, 18);
  EXPECT_EQ(counts.lost, 19);
  EXPECT_EQ(counts.edge, 3);
  EXPECT_TRUE(counts.left_for_good);
  EXPECT_EQ(counts.lost_counted, 2);
  EXPECT_TRUE(counts.gate_passed);
  EXPECT_FALSE(count(track, 0.04).gate_passed);
}

/// Ten frames, gone, and then what `later` makes of frames 20 to 39.
Track left_and_back(double step) {
  Track track;
  for (int k = 0; k < 40; ++k) {
    TrackPoint& p = track.points.emplace_back();
    p.frame = k;
    p.status = k < 10 || k >= 20 ? TrackStatus::ok : TrackStatus::lost;
    p.x = 5 + step * k;
  }
  return track;
}

TEST(AMarkOnTheGround, DoesNotReplaceAPartThatHasLeft) {
  Track still = left_and_back(0.01), moving = left_and_back(0.1);
  const auto said = without_a_mark(still, 20);
  ASSERT_TRUE(said);
  EXPECT_NE(said->find("frames 20 to 39"), std::string::npos);
  EXPECT_EQ(count(still, 0.1).ok, 10);
  EXPECT_FALSE(without_a_mark(moving, 20));
  EXPECT_EQ(count(moving, 0.1).ok, 30);
}

/// A hand-held camera moves all of the picture.
TEST(AFoundDisc, ThatGoesWhereTheGroundGoesIsQuestioned) {
  Track track;
  track.has_marker = true;
  for (int k = 0; k < 40; ++k) {
    const double sway = 12 * std::sin(0.2 * k);
    TrackPoint p;
    p.status = TrackStatus::ok;
    p.x = 60 + sway + 0.05 * (k % 3);
    p.y = 40;
    p.marker = MarkerPoint{100 + sway, 30, 0.01, 1};
    track.points.push_back(p);
  }
  const Circle disc{60, 40, 12};
  EXPECT_EQ(rest_warning(track, disc, false), std::nullopt);
  EXPECT_THAT(rest_warning(track, disc, true).value_or(""), testing::HasSubstr("goes where the ground goes"));
  track.points.back().x += 2;
  EXPECT_EQ(rest_warning(track, disc, true), std::nullopt);
  for (TrackPoint& p : track.points) p.marker.reset();
  EXPECT_EQ(rest_warning(track, disc, true), std::nullopt);
}

}  // namespace
}  // namespace tribotrack::vision
