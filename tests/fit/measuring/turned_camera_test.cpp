// What the phase counts from decides what a turned camera, or a delay, does to the fitted lag.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "fit/campaign.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

constexpr double pi = std::numbers::pi;

/// The runs as a camera turned by `turn` sees them: the picture's content turns by +turn, and the platform's
/// phase, told by its motion along the picture's x axis, by -turn where it circles clockwise, +turn where
/// not.
Problem seen_by_turned_camera(const std::vector<model::Scenario>& truth, double turn, bool gate_in_picture) {
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  for (const auto& scenario : truth) {
    SummaryRun run = test::summary_run(scenario, 0.01, 0.05e-3);
    const double phase_turn = scenario.drive.phase_shift > 0 ? -turn : turn;
    run.scenario.start_phase += phase_turn;
    if (gate_in_picture) run.scenario.friction.phase += phase_turn;
    const Eigen::Matrix2d rotation = Eigen::Rotation2Dd(turn).toRotationMatrix();
    run.measured.vector = rotation * run.measured.vector;
    run.measured.covariance = rotation * run.measured.covariance * rotation.transpose();
    derive_alpha_and_v(run.measured);
    problem.summary_runs.push_back(run);
  }
  return problem;
}

double lag_of(const Problem& problem) {
  FitOptions options{.profiles = false};
  const FitResult result = estimate(problem, options);
  EXPECT_TRUE(result.usable());
  return result.value(FitParameter::lag);
}

TEST(TurnedCamera, CancelsWithAGateInThePictureAndStandsInTheLagWithout) {
  const test::Truth truth;
  for (const double sense : {1.0, -1.0}) {
    auto runs = test::fourteen(truth);
    runs.resize(11);
    for (auto& run : runs) run.drive.phase_shift = sense * pi / 2;
    for (const double turn : {0.0, 0.3, -1.1, 2.9}) {
      EXPECT_NEAR(lag_of(seen_by_turned_camera(runs, turn, true)), truth.lag, 1e-5) << sense << " " << turn;
      EXPECT_NEAR(
          std::remainder(lag_of(seen_by_turned_camera(runs, turn, false)) - truth.lag + sense * turn, 2 * pi),
          0, 1e-5)
          << sense << " " << turn;
    }
  }
}

/// lag + w delay moves the pulses: two w tell both.
Problem lag_and_delay(const std::vector<double>& frequencies, double lag, double delay) {
  Problem problem;
  problem.free = {FitParameter::lag, FitParameter::delay};
  problem.fixed = {{FitParameter::mu1, 0.1}, {FitParameter::mu2, 0.0125}};
  for (const double w : frequencies)
    for (const double phi : {0.0, 2.0}) {
      model::Scenario s = test::scenario({0.1, 0.0125, lag + w * delay}, phi, pi / 3);
      s.drive.angular_frequency = w;
      s.drive.amplitude = s.drive.amplitude_y = 0.28e-3 * std::pow(62.8 / w, 2);
      problem.summary_runs.push_back(test::summary_run(s, 0.01, 0.05e-3));
    }
  return problem;
}

TEST(LagAndDelay, AreToldApartByTwoFrequencies) {
  FitOptions options{.profiles = false};
  const FitResult both = estimate(lag_and_delay({62.8, 45.0}, 0.15, 2e-3), options);
  EXPECT_TRUE(both.usable());
  EXPECT_NEAR(both.value(FitParameter::lag), 0.15, 1e-5);
  EXPECT_NEAR(both.value(FitParameter::delay), 2e-3, 1e-7);
}

}  // namespace
}  // namespace tribotrack::fit
