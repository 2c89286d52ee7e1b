#include "fit/slides/blows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "fit/estimate.h"
#include "fit/free_slides.h"

namespace tribotrack::fit {
namespace {

using internal::find_blows;
using internal::longest_clean_stretch;
using testing::HasSubstr;

/// A point that is braked by `mu` and whose velocity is set anew at given times.
struct Strike {
  double time;
  Eigen::Vector2d velocity;
};
TrackTable struck(double mu, const std::vector<Strike>& strikes, double rate, double duration, double sigma,
                  std::mt19937& random) {
  std::normal_distribution<double> normal;
  TrackTable track;
  Eigen::Vector2d x = Eigen::Vector2d::Zero(), u = x;
  std::size_t next = 0;
  constexpr int kSteps = 200;  // a frame
  for (int k = 0; k / rate < duration; ++k) {
    track.time.push_back(k / rate);
    track.frame.push_back(100 + k);
    track.position.push_back(x + sigma * Eigen::Vector2d(normal(random), normal(random)));
    track.covariance.push_back(sigma * sigma * Eigen::Matrix2d::Identity());
    for (int i = 0; i < kSteps; ++i) {
      const double t = (k + static_cast<double>(i) / kSteps) / rate, h = 1 / (rate * kSteps);
      if (next < strikes.size() && t >= strikes[next].time) u = strikes[next++].velocity;
      const double lost = mu * 9.81 * h, speed = u.norm();
      u = speed > lost ? Eigen::Vector2d(u * (1 - lost / speed)) : Eigen::Vector2d::Zero();
      x += h * u;
    }
  }
  return track;
}

TEST(Blows, NoneInSlidesFromStrikeToStop) {
  std::mt19937 random(21);
  for (const double rate : {120.0, 240.0, 1000.0})
    for (const double sigma : {3e-6, 30e-6, 200e-6})
      for (const double mu : {0.1, 0.3}) {
        SCOPED_TRACE(testing::Message() << rate << " Hz, " << sigma << " m, mu " << mu);
        const TrackTable track = struck(mu, {{-1, {0.5, 0.2}}}, rate, 0.7, sigma, random);
        EXPECT_TRUE(find_blows(track).empty());
      }
}

TEST(Blows, RarelyOneByChance) {
  std::mt19937 random(22);
  int false_alarms = 0;
  for (int round = 0; round < 300; ++round)
    false_alarms += !find_blows(struck(0.17, {{-1, {0.5, 0.2}}}, 240, 0.5, 50e-6, random)).empty();
  EXPECT_LE(false_alarms, 3);
}

TEST(Blows, ACollisionIsFoundToTheFrame) {
  std::mt19937 random(23);
  for (const double loss : {0.4, 1.0}) {
    SCOPED_TRACE(loss);
    const Eigen::Vector2d after =
        0.45 * (1 - loss) * Eigen::Vector2d(1, 0) + Eigen::Vector2d(0, 0.1 * (1 - loss));
    const TrackTable track = struck(0.17, {{-1, {0.6, 0}}, {0.1, after}}, 240, 0.5, 50e-6, random);
    const auto blows = find_blows(track);
    ASSERT_EQ(blows.size(), 1u);
    EXPECT_NEAR(static_cast<double>(blows.front().row), 0.1 * 240 + 1, 1);
    EXPECT_NEAR(blows.front().before.norm(), 0.6 - 0.17 * 9.81 * 0.1, 0.05);
    EXPECT_NEAR(blows.front().after.norm(), after.norm(), 0.05);
  }
}

TEST(Blows, StrikeFromRestAndALaterOneAreBothFound) {
  std::mt19937 random(24);
  const TrackTable track = struck(0.17, {{0.1, {0.5, 0}}, {0.3, {-0.2, 0.6}}}, 240, 0.9, 40e-6, random);
  const auto blows = find_blows(track);
  ASSERT_EQ(blows.size(), 2u);
  const auto stretch = longest_clean_stretch(track, blows);
  EXPECT_GE(stretch.first, blows[1].row) << "0.63 m/s slide longer than 0.2 s";
  EXPECT_EQ(stretch.last, track.time.size());
}

TEST(Blows, ALongRestIsNoSlide) {
  std::mt19937 random(26);
  const TrackTable track = struck(0.17, {{0.05, {0.9, 0}}, {0.2, {0.05, 0.03}}}, 240, 4, 40e-6, random);
  const auto stretch = longest_clean_stretch(track, find_blows(track));
  EXPECT_LT(track.time[stretch.last - 1], 0.21);
  EXPECT_GT(track.time[stretch.first], 0.04);
}

TEST(Blows, TheFitUsesTheLongestCleanStretchAndSaysSo) {
  std::mt19937 random(25);
  TrajectoryRun run;
  run.name = "struck";
  run.free_slide = true;
  run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
  run.track = struck(0.17, {{0.05, {0.6, 0}}, {0.25, {0.05, 0.03}}}, 240, 0.6, 40e-6, random);
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.trajectory_runs = {run};
  FitOptions options{.profiles = false, .next_experiment = false};
  const FitResult fit = estimate(problem, options);
  const SlideResult& slide = fit.slides.front();
  ASSERT_EQ(slide.blows.size(), 1u) << "the strike that starts the slide is none";
  EXPECT_NEAR(static_cast<double>(slide.blows.front().frame), 100 + 0.25 * 240 + 1, 1);
  EXPECT_LT(slide.last_frame, slide.blows.front().frame);
  EXPECT_NEAR(slide.mu1.value, 0.17, 4 * slide.mu1.sd);
  EXPECT_LT(slide.mu1.sd, 0.004);
  ASSERT_FALSE(fit.warnings.empty());
  EXPECT_THAT(fit.warnings.back(), HasSubstr("a blow or a collision, at frame"));
  EXPECT_THAT(slide.sentence, HasSubstr("Its longest stretch without one"));
}

}  // namespace
}  // namespace tribotrack::fit
