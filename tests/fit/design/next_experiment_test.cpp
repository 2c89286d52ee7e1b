// Whether the run to film next keeps its promise, by filming it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <atomic>
#include <map>
#include <numbers>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"
#include "model/trajectory.h"

namespace tribotrack::fit {
namespace {

using test::Truth;
constexpr double pi = std::numbers::pi;
constexpr double kSigma = 1e-4;  ///< m per axis
const Truth kTruth;

FitOptions quick(bool next) {
  FitOptions options;
  options.profiles = false;
  options.multi_starts = 1;
  options.next_experiment = next;
  return options;
}

/// Filmed without noise, with a stated sigma of kSigma.
SummaryRun film(const model::Scenario& scenario) {
  SummaryRun run = test::summary_run(scenario, 0.01, 0.05e-3);
  run.measured.covariance = kSigma * kSigma * Eigen::Matrix2d::Identity();
  run.measured.given_as_velocity = false;
  return run;
}

Problem with_runs(const std::vector<SummaryRun>& runs) {
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  problem.start = {
      {FitParameter::mu1, kTruth.mu1}, {FitParameter::mu2, kTruth.mu2}, {FitParameter::lag, kTruth.lag}};
  problem.summary_runs = runs;
  return problem;
}

/// A sweep of phi alone: mu1 and lag hide each other.
Problem sweep_of_phi() {
  std::vector<SummaryRun> runs;
  for (int k = 0; k < 6; ++k) runs.push_back(film(test::scenario(kTruth, k * pi / 3, pi / 3)));
  return with_runs(runs);
}

model::Scenario advised(const NextExperiment& next) {
  model::Scenario scenario = test::scenario(kTruth, next.phi, next.dtau);
  scenario.drive.amplitude = scenario.drive.amplitude_y = next.amplitude;
  scenario.drive.angular_frequency = next.angular_frequency;
  return scenario;
}

/// Each stage counts up to all there is to do, and one thread at a time reports it.
TEST(Fit, TellsHowFarItIs) {
  FitOptions options = quick(true);
  options.multi_starts = 4;
  options.bootstrap = 30;
  options.threads = 2;
  std::map<std::string, std::pair<std::size_t, std::size_t>> told;
  std::atomic<int> inside = 0;
  options.progress = [&](const char* stage, std::size_t done, std::size_t total) {
    EXPECT_EQ(++inside, 1);
    EXPECT_GT(done, told[stage].first);
    EXPECT_LE(done, total);
    told[stage] = {done, total};
    --inside;
  };
  std::vector<SummaryRun> runs;
  for (int k = 1; k <= 5; ++k) runs.push_back(film(test::scenario(kTruth, 0.4 * k, k * pi / 6)));
  estimate(with_runs(runs), options);
  EXPECT_EQ(told.at("bootstrap"), std::make_pair(std::size_t{30}, std::size_t{30}));
  EXPECT_TRUE(told.contains("starts"));
  EXPECT_EQ(told.at("next experiment").first, told.at("next experiment").second);
}

TEST(NextExperiment, ThePredictedSdIsThatOfTheFitWithIt) {
  Problem problem = sweep_of_phi();
  const FitResult before = estimate(problem, quick(true));
  ASSERT_TRUE(before.next_experiment);
  std::vector<NextExperiment> all = before.other_next_experiments;
  all.push_back(*before.next_experiment);
  ASSERT_GE(all.size(), 2U);
  bool another_drive = false;
  for (const NextExperiment& next : all) {
    SCOPED_TRACE(next.sentence);
    another_drive = another_drive || next.amplitude != 0.28e-3 || next.angular_frequency != 62.8;
    Problem more = problem;
    more.summary_runs.push_back(film(advised(next)));
    const FitResult after = estimate(more, quick(false));
    for (std::size_t i = 0; i < 3; ++i) {
      const ParameterEstimate& p = after.parameters[i];
      const double predicted = next.predicted_sd.at(p.parameter);
      EXPECT_NEAR(p.sd, predicted, 0.02 * predicted);
      EXPECT_LT(predicted, before.parameters[i].sd);
      const Interval interval = next.predicted_ci95.at(p.parameter);
      EXPECT_NEAR(interval.low, p.ci95.low, 0.05 * p.sd);
      EXPECT_NEAR(interval.high, p.ci95.high, 0.05 * p.sd);
    }
  }
  EXPECT_TRUE(another_drive);
}

TEST(NextExperiment, OfTracksIsATrack) {
  const unsigned seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const auto track = [&](const model::Scenario& truth) {
    TrajectoryRun run;
    run.name = "run";
    run.scenario = truth;
    run.scenario.friction.nominal = run.scenario.friction.reduced = 0.05;
    run.scenario.friction.lag = 0;
    run.start_phase_sd = 0.01;
    run.track.platform_frame = true;
    std::normal_distribution<double> noise(0, 2e-6);
    const model::Trajectory path = model::integrate(truth);
    for (int k = 0; k <= 150; ++k) {
      run.track.time.push_back(k * 4e-3);
      run.track.position.push_back(path.at(k * 4e-3).position +
                                   Eigen::Vector2d(noise(random), noise(random)));
      run.track.covariance.push_back(4e-12 * Eigen::Matrix2d::Identity());
    }
    return run;
  };
  Problem problem = with_runs({});
  problem.trajectory_runs = {track(test::scenario(kTruth, 0.3, pi / 6, 6))};
  const FitResult before = estimate(problem, quick(true));
  ASSERT_TRUE(before.next_experiment);
  const NextExperiment& next = *before.next_experiment;
  problem.trajectory_runs.push_back(track(advised(next)));
  const FitResult after = estimate(problem, quick(false));
  for (std::size_t i = 0; i < 3; ++i) {
    const double predicted = next.predicted_sd.at(after.parameters[i].parameter);
    EXPECT_NEAR(after.parameters[i].sd, predicted, 0.1 * predicted);
    EXPECT_LT(predicted, before.parameters[i].sd);
  }
}

}  // namespace
}  // namespace tribotrack::fit
