// Fits to every tracked point: driven runs and free slides.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"
#include "model/trajectory.h"

namespace tribotrack::fit {
namespace {

using test::Truth;
using testing::HasSubstr;
constexpr double pi = std::numbers::pi;

const FitOptions kQuick{.multi_starts = 2, .profiles = false};

TrajectoryRun driven(const model::Scenario& truth, double rate, double sigma, std::mt19937& random,
                     bool platform_frame = true) {
  TrajectoryRun run;
  run.name = "driven";
  run.scenario = truth;
  run.scenario.friction.nominal = run.scenario.friction.reduced = 0.05;
  run.scenario.friction.lag = 0;
  const model::Trajectory path = model::integrate(truth);
  std::normal_distribution<double> noise;
  for (int k = 0; k / rate <= truth.end_time(); ++k) {
    const double time = k / rate;
    Eigen::Vector2d seen = path.at(time).position + sigma * Eigen::Vector2d(noise(random), noise(random));
    if (!platform_frame)
      seen += truth.drive.displacement(truth.start_phase + truth.drive.angular_frequency * time);
    run.track.time.push_back(time + 0.7);  // the recording's clock started earlier
    run.track.frame.push_back(static_cast<long>(run.track.frame.size()) + 350);
    run.track.position.push_back(seen);
    run.track.covariance.push_back(sigma * sigma * Eigen::Matrix2d::Identity());
  }
  const Eigen::Vector2d first = run.track.position.front();
  for (auto& p : run.track.position) p -= first;
  run.track.platform_frame = platform_frame;
  return run;
}

/// Straight sliding, mu g; `rest_before` seconds at rest first, as before a strike.
TrajectoryRun slide(double mu, double speed, double angle, double rate, double duration, double sigma,
                    std::mt19937& random, double rest_before = 0) {
  TrajectoryRun run;
  run.name = "slide";
  run.free_slide = true;
  run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
  const double deceleration = mu * 9.81, stop = speed / deceleration;
  std::normal_distribution<double> noise;
  for (int k = 0; k / rate <= duration; ++k) {
    const double t = std::clamp(k / rate - rest_before, 0.0, stop);
    const double s = speed * t - 0.5 * deceleration * t * t;
    run.track.time.push_back(k / rate);
    run.track.frame.push_back(k);
    run.track.position.push_back(s * Eigen::Vector2d(std::cos(angle), std::sin(angle)) +
                                 sigma * Eigen::Vector2d(noise(random), noise(random)));
    run.track.covariance.push_back(sigma * sigma * Eigen::Matrix2d::Identity());
  }
  return run;
}

/// mu1, mu2 and the lag from every point of two runs, in the platform's and in the camera's frame.
class TwoRuns : public testing::TestWithParam<bool> {
 protected:
  TwoRuns() {
    problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
    std::mt19937 random(11);
    for (const auto& [phi, dtau] : {std::pair{0.3, pi / 3}, {2.0, pi / 2}})
      problem.trajectory_runs.push_back(
          driven(test::scenario({}, phi, dtau, 6), 250, 0.5e-6, random, GetParam()));
  }
  static void expect_truth(const FitResult& result) {
    const Truth truth;
    const double truths[] = {truth.mu1, truth.mu2, truth.lag};
    EXPECT_EQ(result.scatter, 0) << result.full_report();
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(result.parameters[i].estimate, truths[i], 4 * result.parameters[i].sd);
  }
  Problem problem;
};

TEST_P(TwoRuns, PinAllThree) {
  const FitResult result = estimate(problem, kQuick);
  EXPECT_TRUE(result.usable()) << result.full_report();
  EXPECT_GT(result.p_value, 1e-3);
  expect_truth(result);
  EXPECT_LT(result.parameters[0].sd, 1e-4);
  EXPECT_EQ(result.runs[0].points, problem.trajectory_runs[0].track.time.size());
  EXPECT_NEAR(result.runs[0].rms_m, 0.5e-6 * std::sqrt(2.0), 0.1e-6);
}

// A platform phase wrong by 0.02 rad: taken as exact it spoils the fit, with its sd it is found.
TEST_P(TwoRuns, FindThePlatformsPhase) {
  problem.trajectory_runs[0].scenario.start_phase += 0.02;
  const FitResult blind = estimate(problem, kQuick);
  EXPECT_GT(blind.scatter, 0);
  for (auto& run : problem.trajectory_runs) run.start_phase_sd = 0.03;
  const FitResult seeing = estimate(problem, kQuick);
  expect_truth(seeing);
  for (const RunResult& run : seeing.runs) EXPECT_NEAR(run.nuisance.at("start_phase_rad"), 0, 2e-3);
}

INSTANTIATE_TEST_SUITE_P(PlatformFrame, TwoRuns, testing::Bool());

TEST(FreeSlide, GivesMu1AndTheInitialSpeed) {
  std::mt19937 random(17);
  for (const bool stops : {false, true}) {
    Problem problem;
    problem.free = {FitParameter::mu1};
    problem.trajectory_runs = {slide(0.15, 0.8, 0.4, 240, stops ? 0.8 : 0.4, 20e-6, random)};
    FitOptions options = kQuick;
    options.profiles = true;
    const FitResult result = estimate(problem, options);
    EXPECT_TRUE(result.usable()) << result.full_report();
    const auto& mu1 = result.parameters[0];
    EXPECT_NEAR(mu1.estimate, 0.15, 4 * mu1.sd);
    EXPECT_LT(mu1.sd, 0.002);
    EXPECT_LT(mu1.profile_ci95.low, mu1.estimate);
    EXPECT_GT(mu1.profile_ci95.high, mu1.estimate);
    EXPECT_NEAR(mu1.profile_ci95.high, mu1.ci95.high, 0.3 * mu1.sd);
    EXPECT_NEAR(result.runs[0].nuisance.at("initial_speed_mm_s"), 800, 5);
    EXPECT_NEAR(result.runs[0].nuisance.at("stop_time_s"), 0.8 / (0.15 * 9.81), 0.01);
  }
}

TEST(FreeSlide, FramesBeforeTheStrikeAreLeftOut) {
  std::mt19937 random(3);
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.trajectory_runs = {slide(0.12, 0.9, 0, 240, 0.6, 20e-6, random, 0.1)};
  const FitResult result = estimate(problem, kQuick);
  const double onset = result.runs[0].nuisance.at("onset_frame");
  EXPECT_GE(onset, 24);
  EXPECT_LE(onset, 36);
  EXPECT_NEAR(result.value(FitParameter::mu1), 0.12, 4 * result.parameters[0].sd);
  EXPECT_EQ(result.scatter, 0) << result.full_report();
}

// Perspective bends the path slowly: residuals far above sigma and correlated must widen the interval.
TEST(FreeSlide, CorrelatedScatterWidensTheInterval) {
  std::mt19937 random(29);
  std::normal_distribution<double> normal;
  int inside = 0;
  const int trials = 100;
  for (int trial = 0; trial < trials; ++trial) {
    Problem problem;
    problem.free = {FitParameter::mu1};
    problem.trajectory_runs = {slide(0.15, 0.8, 0.1, 240, 0.4, 5e-6, random)};
    Eigen::Vector2d wander = Eigen::Vector2d::Zero();
    const double rho = 0.8;
    for (auto& p : problem.trajectory_runs[0].track.position) {
      wander =
          rho * wander + std::sqrt(1 - rho * rho) * 150e-6 * Eigen::Vector2d(normal(random), normal(random));
      p += wander;
    }
    const FitResult result = estimate(problem, kQuick);
    ASSERT_GT(result.scatter, 0);
    EXPECT_GT(result.runs[0].nuisance.at("correlation_time_points"), 1.5);
    inside += result.parameters[0].ci95.low <= 0.15 && 0.15 <= result.parameters[0].ci95.high;
  }
  EXPECT_GE(inside, 0.88 * trials);  // binomial: 95 +- 2.2
}

TEST(FreeSlide, OnlyMu1IsKnownToIt) {
  std::mt19937 random(3);
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2};
  problem.trajectory_runs = {slide(0.12, 0.9, 0, 240, 0.4, 20e-6, random)};
  const FitResult result = estimate(problem, kQuick);
  EXPECT_FALSE(result.usable());
  ASSERT_FALSE(result.identifiability.weak_directions.empty());
  EXPECT_THAT(result.identifiability.weak_directions[0],
              HasSubstr("mu2 moves no observable: a free slide depends on mu1"));
  problem.free = {FitParameter::mu1};
  problem.trajectory_runs[0].track.time.resize(5);
  problem.trajectory_runs[0].track.position.resize(5);
  problem.trajectory_runs[0].track.covariance.resize(5);
  EXPECT_THROW(estimate(problem, kQuick), DataError);
}

TEST(TrajectoryFit, KindsMixAndShareMu1) {
  std::mt19937 random(8);
  auto scenarios = test::fourteen({});
  scenarios.resize(8);
  Problem problem = test::problem_of(scenarios, 0.02, 0.1e-3, &random);
  const FitResult alone = estimate(problem, kQuick);
  problem.trajectory_runs = {slide(0.1, 0.8, 0.4, 240, 0.7, 20e-6, random)};
  const FitResult both = estimate(problem, kQuick);
  // mu1 from the slide breaks the trade-off with the lag.
  EXPECT_LT(both.parameters[0].sd, 0.3 * alone.parameters[0].sd);
  EXPECT_LT(both.parameters[2].sd, 0.5 * alone.parameters[2].sd);
  EXPECT_NEAR(both.value(FitParameter::mu1), 0.1, 4 * both.parameters[0].sd);
  EXPECT_EQ(both.runs.size(), 9U);
}

}  // namespace
}  // namespace tribotrack::fit
