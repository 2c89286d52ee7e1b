#include "vision/survey.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

/// A platform that circles by 3 px in 25 frames with a mark on it, a screw that rests, a disc that walks, and
/// a lamp that is lit in 5 frames of each turn.
struct Bench {
  double amplitude = 3, walk_px = 0.6;
  bool mark = true, screw = true, lamp = false, speck = false, highlight = false;
  int frames = 150;

  Picture at(std::int64_t k) const {
    const double phase = 2 * std::numbers::pi * static_cast<double>(k) / 25;
    const double x = amplitude * std::cos(phase), y = amplitude * std::sin(phase);
    test::TestScene scene;
    scene.width = 240;
    scene.height = 160;
    scene.discs = {{60 + x + walk_px * static_cast<double>(k), 100 + y, 22, 0, 170, {}}};
    if (highlight) scene.discs.push_back({65 + x + walk_px * static_cast<double>(k), 95 + y, 7, 0, 235, {}});
    if (mark) scene.discs.push_back({200 + x, 40 + y, 10, 0, 10, {}});
    if (screw) scene.discs.push_back({30, 30, 13, 0, 140, {}});
    if (speck) scene.discs.push_back({120 + x, 30 + y, 2.5, 0, 200, {}});
    if (lamp) scene.discs.push_back({210, 120, 5, 0, k % 25 < 5 ? 240.0 : 40.0, {}});
    std::mt19937 random(static_cast<unsigned>(k) + 1);
    return test::noisy(scene.render(), 1.5, random);
  }
  Survey seen() const {
    test::RenderedSource source(240, 160, frames, [this](std::int64_t k) { return at(k); });
    return survey(source);
  }
};

void expect_circle(const Circle& circle, double x, double y, double radius) {
  EXPECT_NEAR(circle.x, x, 0.5);
  EXPECT_NEAR(circle.y, y, 0.5);
  EXPECT_NEAR(circle.radius, radius, 0.5);
}

TEST(Survey, TellsPartMarkAndWhatRestsByHowTheyMove) {
  const Survey seen = Bench().seen();
  EXPECT_EQ(seen.frame, 0);
  ASSERT_EQ(seen.discs.size(), 3U);
  EXPECT_EQ(seen.discs[0].role, DiscRole::part);
  expect_circle(seen.discs[0].circle, 63, 100, 22);
  EXPECT_GT(seen.discs[0].moved_px, 40);
  EXPECT_EQ(seen.discs[1].role, DiscRole::mark);
  expect_circle(seen.discs[1].circle, 203, 40, 10);
  EXPECT_GT(seen.discs[1].moved_px, 1);
  EXPECT_LT(seen.discs[1].moved_px, 6.5) << "no farther than across the platform's circle";
  EXPECT_EQ(seen.discs[2].role, DiscRole::resting);
  expect_circle(seen.discs[2].circle, 30, 30, 13);
  EXPECT_TRUE(seen.platform_moves());
  EXPECT_THAT(seen.lamps, testing::IsEmpty());
}

TEST(Survey, AHighlightOnThePartIsNotThePart) {
  Bench bench;
  bench.walk_px = 0.12;  // by less than the part's radius, by more than the highlight's
  bench.highlight = true;
  const Survey seen = bench.seen();
  ASSERT_NE(seen.part(), nullptr);
  expect_circle(seen.part()->circle, 63, 100, 22);
  ASSERT_NE(seen.mark(), nullptr);
  expect_circle(seen.mark()->circle, 203, 40, 10);
}

TEST(Survey, NothingMovesOnAPlatformAtRest) {
  Bench bench;
  bench.amplitude = bench.walk_px = 0;
  const Survey seen = bench.seen();
  ASSERT_EQ(seen.discs.size(), 3U);
  expect_circle(seen.part()->circle, 60, 100, 22);
  EXPECT_EQ(seen.mark(), nullptr);
  EXPECT_FALSE(seen.platform_moves());
}

TEST(Survey, APartThatOnlyCirclesIsTheLargestDisc) {
  Bench bench;
  bench.walk_px = 0;
  expect_circle(bench.seen().part()->circle, 63, 100, 22);
}

TEST(Survey, FindsTheLampAndDoesNotTakeItForADisc) {
  Bench bench;
  bench.lamp = true;
  const Survey seen = bench.seen();
  ASSERT_EQ(seen.lamps.size(), 1U);
  const SurveyedLamp& lamp = seen.lamps.front();
  EXPECT_NEAR(lamp.circle.x, 210, 1);
  EXPECT_NEAR(lamp.circle.y, 120, 1);
  EXPECT_NEAR(lamp.circle.radius, 5, 1);
  EXPECT_NEAR(lamp.lit_share, 0.2, 0.02);
  EXPECT_NEAR(lamp.lit, 240, 15);
  EXPECT_NEAR(lamp.dark, 40, 15);
  EXPECT_EQ(seen.discs.size(), 3U);
}

// Places that a bright speck passes switch as well, but no light is added.
TEST(Survey, ASpeckThatMovesWithThePlatformIsNoLamp) {
  Bench bench;
  bench.speck = true;
  EXPECT_THAT(bench.seen().lamps, testing::IsEmpty());
}

TEST(Survey, OneFrameIsLookedAt) {
  Bench bench;
  bench.frames = 1;
  const Survey seen = bench.seen();
  ASSERT_EQ(seen.discs.size(), 3U);
  EXPECT_EQ(seen.frames_looked_at, 1);
  expect_circle(seen.part()->circle, 63, 100, 22);
}

// Evenly spaced frames would see a lamp of the same period always lit, or never.
TEST(SpreadFrames, AreInStepWithNoPeriod) {
  const auto frames = spread_frames(3000, 160);
  for (int period = 2; period <= 60; ++period) {
    int first_half = 0;
    for (const std::int64_t frame : frames) first_half += 2 * (frame % period) < period;
    EXPECT_NEAR(first_half / static_cast<double>(frames.size()), (period + 1) / 2 / double(period), 0.12)
        << period;
  }
}

}  // namespace
}  // namespace tribotrack::vision
