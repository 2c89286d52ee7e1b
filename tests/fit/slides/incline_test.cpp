// A part on an incline against the closed form, u' = g (sin(theta) - mu cos(theta)) downhill.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fit/estimate.h"
#include "fit/measurement.h"

namespace tribotrack::fit {
namespace {

using testing::HasSubstr;

constexpr double kGravity = 9.81, kSigma = 2e-5;

struct Incline {
  double slope = 0.5;                                 ///< as TrajectoryRun's
  double mu = 0.2;                                    ///
  double speed = 0;                                   ///< at first, in the direction of the motion, m/s
  double heading = 0.4;                               ///< of the motion in the picture
  int resting = 0, sliding = 120, resting_after = 0;  ///< frames
};

/// Frames at 500 Hz.
TrajectoryRun track_of(const Incline& incline, std::mt19937& random) {
  std::normal_distribution<double> noise(0, kSigma);
  TrajectoryRun run;
  run.name = "slide";
  run.free_slide = true;
  run.slope = incline.slope;
  run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
  run.scenario.drive.gravity = kGravity;
  const double theta = std::abs(incline.slope), down = incline.slope > 0 ? 1 : -1;
  const double acceleration = kGravity * (down * std::sin(theta) - incline.mu * std::cos(theta));
  const double stop = acceleration < 0 ? -incline.speed / acceleration : 1e9;
  const Eigen::Vector2d along(std::cos(incline.heading), std::sin(incline.heading));
  for (int k = 0; k < incline.resting + incline.sliding + incline.resting_after; ++k) {
    const double t = std::clamp(0.002 * (k - incline.resting), 0.0, std::min(stop, 0.002 * incline.sliding));
    run.track.frame.push_back(k);
    run.track.time.push_back(0.002 * k);
    run.track.position.emplace_back(along * (incline.speed * t + 0.5 * acceleration * t * t) +
                                    Eigen::Vector2d(noise(random), noise(random)));
    run.track.covariance.emplace_back(kSigma * kSigma * Eigen::Matrix2d::Identity());
  }
  return run;
}

FitResult fit_of(const std::vector<TrajectoryRun>& runs, double slope_sd = 0) {
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.trajectory_runs = runs;
  if (slope_sd > 0) problem.conditions.push_back({FitParameter::slope, slope_sd, "test"});
  FitOptions options{.profiles = false, .next_experiment = false};
  return estimate(problem, options);
}

class AnIncline : public testing::TestWithParam<Incline> {};

TEST_P(AnIncline, GivesMuWithIntervalsThatHold) {
  constexpr int kTracks = 60;
  std::mt19937 random(7);
  int inside = 0;
  double pull = 0;
  for (int k = 0; k < kTracks; ++k) {
    const FitResult fit = fit_of({track_of(GetParam(), random)});
    const ParameterEstimate& mu1 = fit.parameters.front();
    inside += mu1.ci95.low < GetParam().mu && GetParam().mu < mu1.ci95.high;
    pull += (mu1.estimate - GetParam().mu) / mu1.sd / kTracks;
    EXPECT_LT(mu1.sd, 0.05 * std::max(GetParam().mu, 0.05));
  }
  EXPECT_GE(inside, 51);  // of 57: chance allows less in 1 of 100
  EXPECT_LT(std::abs(pull), 0.45);
}

INSTANTIATE_TEST_SUITE_P(
    Slides, AnIncline,
    testing::Values(Incline{.slope = 0.5, .mu = 0.2}, Incline{.slope = 0.5, .mu = 0.2, .resting = 200},
                    Incline{.slope = 0.75, .mu = 0.5, .speed = 0.3, .heading = 2.5},
                    Incline{.slope = 0.3, .mu = 0.2, .heading = -1.57, .resting = 40, .resting_after = 30},
                    Incline{.slope = 0.2, .mu = 0.35, .speed = 0.4, .resting = 300, .sliding = 150},
                    Incline{.slope = -0.3, .mu = 0.15, .speed = 0.9, .sliding = 90},
                    Incline{.slope = 0.1, .mu = 0.01, .sliding = 200}));

// mu = tan(theta) - a / (g cos(theta)), hence d mu / d theta = 1 + mu tan(theta).
TEST(Inclines, CountTheSlopesOwnError) {
  std::mt19937 random(3);
  const Incline incline{.slope = 0.6, .mu = 0.3};
  const TrajectoryRun run = track_of(incline, random);
  const double slope_sd = 0.005;
  const FitResult exact = fit_of({run}), known = fit_of({run}, slope_sd);
  const double of_slope = (1 + incline.mu * std::tan(incline.slope)) * slope_sd;
  EXPECT_NEAR(known.parameters.front().sd, std::hypot(exact.parameters.front().sd, of_slope),
              0.01 * of_slope);
  EXPECT_NEAR(known.parameters.front().estimate, exact.parameters.front().estimate,
              0.05 * of_slope);  // the track itself tells a little about the slope
  const auto in = [](const std::vector<BudgetEntry>& budget) {
    return std::ranges::find(budget, "incline's slope", &BudgetEntry::source);
  };
  ASSERT_NE(in(known.budget), known.budget.end());
  EXPECT_TRUE(in(known.budget)->counted);
  EXPECT_NEAR(in(known.budget)->contribution(0), of_slope, 0.01 * of_slope);
  ASSERT_NE(in(exact.budget), exact.budget.end());
  EXPECT_FALSE(in(exact.budget)->counted);
}

// Down and up the same plane, the angle's error cancels.
TEST(Inclines, UpAndDownKnowTheSlope) {
  std::mt19937 random(5);
  const TrajectoryRun down = track_of({.slope = 0.5, .mu = 0.2}, random);
  TrajectoryRun up = track_of({.slope = -0.5, .mu = 0.2, .speed = 1.2, .sliding = 80}, random);
  up.name = "up";
  const double one = fit_of({down}, 0.01).parameters.front().sd;
  EXPECT_LT(fit_of({down, up}, 0.01).parameters.front().sd, 0.3 * one);
}

TEST(Inclines, AreOfFreeSlidesAndNotSteep) {
  std::mt19937 random(5);
  TrajectoryRun run = track_of({.slope = 0.5}, random);
  run.slope = 1.2;
  EXPECT_THROW(fit_of({run}), DataError);
  run.slope = 0.5;
  run.free_slide = false;
  EXPECT_THROW(fit_of({run}), DataError);
}

// Without its slope it is no free slide, and the message says what may be missing.
TEST(Inclines, WithoutASlopeAreRefused) {
  std::mt19937 random(5);
  TrajectoryRun run = track_of({.slope = 0.5}, random);
  run.slope = 0;
  try {
    fit_of({run});
    FAIL();
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("slope_rad"));
  }
}

}  // namespace
}  // namespace tribotrack::fit
