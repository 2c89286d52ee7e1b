// Parts that change their look as they turn: brushed metal under a lamp.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "vision/analytic_scene.h"
#include "vision/circle_fit_judge.h"
#include "vision/track_errors.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

using test::RenderedSource;
using test::TestScene;

constexpr int kFrames = 120;

Point truth(std::int64_t k) {
  const auto t = static_cast<double>(k);
  return {50.3 + 0.25 * t + 2 * std::cos(0.13 * t), 60.2 - 2 * std::sin(0.13 * t)};
}

struct Metal {
  double through = 3;              ///< rad
  double levels = 30, width = 10;  ///< of streaks that glint one after the other: grey levels, px
  double scratches = 0;            ///< grey levels of what only turns
  bool with_look_alike = false;
  int gone_from = kFrames;
};

RenderedSource metal_that_turns(const Metal& metal = {}) {
  std::mt19937 random(12);
  const test::Waves streaks = test::random_waves(random, 30, metal.width, metal.levels);
  const test::Waves scratches = test::random_waves(random, 30, 6, metal.scratches);
  return {220, 120, kFrames, [=](std::int64_t k) {
            TestScene scene;
            scene.width = 220;
            scene.height = 120;
            const double theta = metal.through * static_cast<double>(k) / kFrames;
            if (k < metal.gone_from) {
              scene.discs = {{truth(k).x, truth(k).y, 22, theta, 140, scratches}};
              for (std::size_t n = 0; n < streaks.waves.size(); ++n) {
                test::Wave w = streaks.waves[n];
                w.phase += (n % 2 == 0 ? 2.0 : -2.0) * theta;
                scene.discs[0].texture.waves.push_back(w);
              }
            }
            if (metal.with_look_alike) scene.discs.push_back({180, 60, 22, 0, 140, {}});
            std::mt19937 noise(static_cast<unsigned>(500 + k));
            return test::noisy(scene.render(), 2, noise);
          }};
}

TrackOptions follow() {
  TrackOptions options;
  options.target = {Target::Kind::disc, {truth(0).x, truth(0).y, 22}, {}};
  return options;
}

const PlanStage& edge_stage_of(const TrackResult& result) {
  for (const PlanStage& s : result.summary.plan)
    if (s.name.starts_with("edge")) return s;
  throw std::logic_error("no such stage");
}

TEST(TurningMetal, IsFoundInEveryFrameBetterThanByACircleFit) {
  RenderedSource source = metal_that_turns();
  const TrackResult result = track(source, follow());
  ASSERT_EQ(result.summary.ok, kFrames);
  const PlanStage& stage = edge_stage_of(result);
  EXPECT_TRUE(stage.on) << stage.reason;
  Eigen::MatrixX2d ours(kFrames, 2), judged(kFrames, 2), sd(kFrames, 2);
  for (const TrackPoint& p : result.track.points) {
    const Circle c = test::circle_fit(source.read(p.frame), {p.x, p.y, 22});
    ours.row(p.frame) << p.x - truth(p.frame).x, p.y - truth(p.frame).y;
    judged.row(p.frame) << c.x - truth(p.frame).x, c.y - truth(p.frame).y;
    sd.row(p.frame) << p.sigma_x, p.sigma_y;
    EXPECT_GT(p.ncc, 0.6);
    EXPECT_LE(p.ncc, 1);
  }
  const auto rms = [](const Eigen::MatrixX2d& e) {
    return std::sqrt((e.rowwise() - e.colwise().mean()).squaredNorm() / (2 * kFrames));
  };
  const double standardised = rms(ours) / std::sqrt(sd.array().square().mean());
  EXPECT_LT(rms(ours), 0.5 * rms(judged));
  EXPECT_GT(standardised, 0.7);
  EXPECT_LT(standardised, 1.6);
}

/// Pictures hold what turns with the part: they drift, and state errors as of a part at rest.
TEST(TurningMetal, ShadingThatTurnsALittleIsNotTakenForMotion) {
  RenderedSource source = metal_that_turns({.through = 0.3, .levels = 8, .width = 100, .scratches = 4});
  const TrackResult result = track(source, follow());
  ASSERT_EQ(result.summary.ok, kFrames);
  Eigen::MatrixX2d errors(kFrames, 2), sd(kFrames, 2);
  for (const TrackPoint& p : result.track.points) {
    errors.row(p.frame) << p.x - truth(p.frame).x, p.y - truth(p.frame).y;
    sd.row(p.frame) << p.sigma_x, p.sigma_y;
  }
  const double rms = std::sqrt((errors.rowwise() - errors.colwise().mean()).squaredNorm() / (2 * kFrames));
  const double standardised = rms / std::sqrt(sd.array().square().mean());
  EXPECT_GT(standardised, 0.7);
  EXPECT_LT(standardised, 1.6);
}

/// A chamfer under a lamp at the side, more or less as bright as the top. Where it shows what turns is seen
/// to end before the outer edge, by which motion and radius are told; where only its outer edge does none is
/// made up beyond that.
TEST(TurningMetal, BehindAWideChamferTheOuterEdgeIsFollowed) {
  constexpr std::int64_t kShort = 24;
  constexpr double kOuter = 60, kTop = 56;
  const auto centre = [](std::int64_t k) {
    const auto t = static_cast<double>(k);
    return Point{80.3 + 4 * std::cos(0.26 * t), 79.8 - 4 * std::sin(0.26 * t)};
  };
  std::mt19937 random(3);
  const test::Waves streaks = test::random_waves(random, 6, 12, 30);
  const auto followed = [&](double level, double lamp) {
    const test::Waves from_a_side = {{{lamp, 0.024, 0.01, -std::numbers::pi / 2}}};
    RenderedSource source(160, 160, kShort, [&](std::int64_t k) {
      TestScene scene;
      scene.width = scene.height = 160;
      const Point c = centre(k);
      scene.discs = {{c.x, c.y, kOuter, 0, level, from_a_side},
                     {c.x, c.y, kTop, 3.0 * static_cast<double>(k) / kShort, 150, streaks}};
      std::mt19937 noise(static_cast<unsigned>(700 + k));
      return test::noisy(scene.render(), 2, noise);
    });
    TrackOptions options;
    options.target = {Target::Kind::disc, {centre(0).x, centre(0).y, level < 100 ? kTop : kOuter}, {}};
    TrackResult result = track(source, options);
    const test::TrackErrors errors = test::errors_of(result.track, centre);
    EXPECT_EQ(errors.count, kShort);
    EXPECT_LT(errors.standardised, 1.6);
    EXPECT_NEAR(result.summary.outer_radius, kOuter, 2 * result.summary.outer_radius_sd) << level;
    return std::pair{errors.rms, result.summary.outer_radius};
  };
  const auto [rms, radius] = followed(90, 20);
  EXPECT_LT(rms, 0.0075);
  EXPECT_NEAR(radius, kOuter, 0.005 * kOuter);
  followed(130, 10);
}

TEST(TurningMetal, ALookAlikeIsNotTakenForMetalThatHasGone) {
  RenderedSource source = metal_that_turns({.with_look_alike = true, .gone_from = 80});
  const TrackResult result = track(source, follow());
  for (const TrackPoint& p : result.track.points) {
    if (p.frame >= 80) {
      EXPECT_EQ(p.status, TrackStatus::lost) << p.frame;
    } else {
      EXPECT_EQ(p.status, TrackStatus::ok) << p.frame;
    }
  }
}

}  // namespace
}  // namespace tribotrack::vision
