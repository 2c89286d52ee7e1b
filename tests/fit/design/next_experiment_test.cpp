// Whether the run to film next keeps its promise, by filming it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <atomic>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "fit/campaign.h"
#include "fit/design/forecast.h"
#include "fit/estimate.h"
#include "fit/tools/stage_progress.h"
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

// A search that is late forecasts nothing more.
TEST(NextExperiment, IsBounded) {
  Problem problem = sweep_of_phi();
  problem.conditions = {{FitParameter::tilt_x, 1e-3, "level"}};  // one by one, not in lanes
  const internal::Unknowns unknowns(problem);
  const internal::Residuals residuals(unknowns);
  const Eigen::VectorXd values = unknowns.first_guess();
  const internal::Forecaster forecaster(residuals, values);
  const std::vector<internal::Candidate> candidates = {forecaster.drive_so_far()};
  internal::Stage late(quick(true), "", 0, internal::Stage::Seconds(0)), early(quick(true), "");
  EXPECT_TRUE(late.late());
  EXPECT_FALSE(early.late());
  EXPECT_FALSE(forecaster.forecasts(candidates, 1e-3, 1, late).front());
  EXPECT_TRUE(forecaster.forecasts(candidates, 1e-3, 1, early).front());
}

/// Forecasts from differences of runs in lanes are those of exact derivatives, whatever is fitted.
TEST(NextExperiment, ForecastsTogetherAreThoseOneByOne) {
  for (const bool drive : {false, true}) {
    Problem problem = sweep_of_phi();
    if (drive) {
      problem.free.push_back(FitParameter::amplitude);
      problem.free.push_back(FitParameter::angular_frequency);
      problem.free[2] = FitParameter::delay;
      problem.start.erase(FitParameter::lag);
      problem.start[FitParameter::delay] = 0.002;  // edges at the very start make a kink
    }
    const internal::Unknowns unknowns(problem);
    internal::Residuals residuals(unknowns);
    const Eigen::VectorXd values = unknowns.first_guess();
    const internal::Forecaster forecaster(residuals, values);
    std::vector<internal::Candidate> candidates;
    for (const double phi : {0.0, 2.0})
      for (const double width : {0.6, 1.7, 2.9, 5.1})
        for (const double share : {1.0, 0.8, 1.25}) {
          candidates.push_back(forecaster.drive_so_far());
          candidates.back().phi = phi;
          candidates.back().dtau = width;
          candidates.back().amplitude *= share;
        }
    const FitOptions options;
    internal::Stage stage(options, "forecasts");
    const auto together = forecaster.forecasts(candidates, 1e-9, 2, stage);
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      const auto alone = forecaster.forecast(candidates[k], 1e-9);
      ASSERT_TRUE(alone && together[k]) << k;
      EXPECT_LT((together[k]->information - alone->information).norm(), 2e-3 * alone->information.norm())
          << k;
    }
  }
}

/// Where mu2 is nearly 0, in the bend of a flat valley, a step to either side would leave the model's range.
TEST(NextExperiment, ThereAreForecastsWhereMu2IsNearlyNothing) {
  const Problem problem = sweep_of_phi();
  const internal::Unknowns unknowns(problem);
  internal::Residuals residuals(unknowns);
  Eigen::VectorXd values = unknowns.first_guess();
  values(*unknowns.find(FitParameter::mu2)) = 1e-9;
  const internal::Forecaster forecaster(residuals, values);
  const internal::Candidate candidate = forecaster.drive_so_far();
  const FitOptions options;
  internal::Stage stage(options, "forecasts");
  const auto together = forecaster.forecasts({candidate}, 1e-9, 1, stage);
  const auto alone = forecaster.forecast(candidate, 1e-9);
  ASSERT_TRUE(alone && together[0]);
  EXPECT_LT((together[0]->information - alone->information).norm(), 2e-3 * alone->information.norm());
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

// No other place of the grid does better, by fits with each of them.
TEST(NextExperimentCampaign, DISABLED_IsTheBestOfTheGrid) {
  Problem problem = sweep_of_phi();
  const FitResult before = estimate(problem, quick(true));
  ASSERT_TRUE(before.next_experiment);
  const auto& advice = before.other_next_experiments;
  const auto for_mu2 = std::find_if(advice.begin(), advice.end(), [](const NextExperiment& next) {
    return next.aim == FitParameter::mu2 && next.amplitude == 0.28e-3 && next.angular_frequency == 62.8;
  });
  const double volume_told = [&] {
    Problem more = problem;
    more.summary_runs.push_back(film(advised(*before.next_experiment)));
    return estimate(more, quick(false)).covariance.determinant();
  }();
  const double mu2_told = for_mu2 == advice.end() ? before.next_experiment->predicted_sd.at(FitParameter::mu2)
                                                  : for_mu2->predicted_sd.at(FitParameter::mu2);
  for (int j = 1; j < 8; ++j)
    for (int k = 0; k < 8; k += 2) {
      Problem more = problem;
      more.summary_runs.push_back(film(test::scenario(kTruth, k * pi / 4, j * pi / 4)));
      const FitResult after = estimate(more, quick(false));
      EXPECT_GE(after.covariance.determinant(), 0.9 * volume_told) << j << ", " << k;
      EXPECT_GE(after.parameters[1].sd, 0.97 * mu2_told) << j << ", " << k;
    }
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
