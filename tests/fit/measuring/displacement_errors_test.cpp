// Is the covariance of a displacement that of its errors? White noise, ends anywhere between frames.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <random>

#include "fit/campaign.h"
#include "fit/measurement.h"
#include "fit/slow_tracks.h"
#include "model/trajectory.h"

namespace tribotrack::fit {
namespace {

using std::numbers::pi;

TEST(DisplacementErrors, AreAsLargeAsTheirCovarianceSays) {
  std::mt19937 random(8);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  // 10, 25 and 50 frames a cycle (at ten the error of interpolating is taken too large rather than too
  // small); noise of 0.05 to 2 um: the error of interpolating weighs much and little.
  for (const double rate : {100.0, 250.0, 500.0})
    for (const double sigma : {0.05e-6, 0.5e-6, 2e-6}) {
      const int runs = 400;
      double square = 0;
      for (int k = 0; k < runs; ++k) {
        const test::Truth truth{uniform(0.07, 0.108), uniform(0.008, 0.03), uniform(-0.5, 0.5)};
        model::Scenario scenario = test::scenario(truth, uniform(0, 2 * pi), uniform(0.5, 3.2), 21);
        scenario.drive.angular_frequency = uniform(60, 65);
        const TrajectoryRun run = test::slow_track(scenario, rate, sigma, {}, random);
        const Displacement measured =
            measure_displacement(run.track, {scenario.drive.angular_frequency, 0}, 20);
        const auto motion = model::integrate(scenario, {});
        const Eigen::Vector2d error =
            measured.vector - (motion.at(measured.duration).position - motion.at(0).position);
        square += error.dot(measured.covariance.ldlt().solve(error)) / (2 * runs);
      }
      EXPECT_LT(std::sqrt(square), 1.08);  // 3 sd of 800 squares
      EXPECT_GT(std::sqrt(square), rate < 200 ? 0.75 : 0.92);
    }
}

// What both ends share does not move one against the other.
TEST(DisplacementErrors, CountWhatBothEndsShare) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> phase(0, 2 * pi);
  const int runs = 400;
  double told = 0, silent = 0;
  for (int k = 0; k < runs; ++k) {
    const model::Scenario scenario = test::scenario({}, phase(random), 1, 21);
    TrajectoryRun run = test::slow_track(scenario, 250, 0.3e-6, {}, random);
    test::add_slow(run.track, {1e-6, 5}, random);
    const double w = scenario.drive.angular_frequency;
    const Displacement measured = measure_displacement(run.track, {w, 0}, 20);
    run.track.slow.clear();
    const Displacement alone = measure_displacement(run.track, {w, 0}, 20);
    const auto motion = model::integrate(scenario, {});
    const Eigen::Vector2d error =
        measured.vector - (motion.at(measured.duration).position - motion.at(0).position);
    told += error.dot(measured.covariance.ldlt().solve(error)) / (2 * runs);
    silent += error.dot(alone.covariance.ldlt().solve(error)) / (2 * runs);
  }
  EXPECT_NEAR(std::sqrt(told), 1, 0.08);  // 3 sd of 800 squares
  EXPECT_LT(std::sqrt(silent), 0.7);
}

// An error that all frames share is none of interpolating between them.
TEST(DisplacementErrors, OfInterpolatingAreNotTakenForOnesThatFramesShare) {
  std::mt19937 random(3);
  const model::Scenario scenario = test::scenario({}, 1, 1, 21);
  const double w = scenario.drive.angular_frequency;
  TrajectoryRun run = test::slow_track(scenario, 100, 0.05e-6, {}, random);
  const Eigen::Matrix2d alone = measure_displacement(run.track, {w, 0}, 20).covariance;
  ASSERT_GT(alone.trace(), 100 * 0.05e-6 * 0.05e-6) << "interpolating is most of the error";
  run.track.slow = {{20e-6, 1e10}};
  for (Eigen::Matrix2d& all : run.track.covariance) all += 20e-6 * 20e-6 * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d shared = measure_displacement(run.track, {w, 0}, 20).covariance;
  EXPECT_NEAR((shared - alone).norm() / alone.norm(), 0, 1e-3);
}

}  // namespace
}  // namespace tribotrack::fit
