// The Jacobian of all residuals against differences, every unknown at once.
#include "fit/residuals/residuals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fit/campaign.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double pi = std::numbers::pi;

TrajectoryRun track(const model::Scenario& scenario, bool platform_frame, std::mt19937& random) {
  std::normal_distribution<double> noise(0, 1e-5);
  TrajectoryRun run;
  run.name = "track";
  run.scenario = scenario;
  run.amplitude_from_track = !platform_frame;
  run.start_phase_sd = 0.1;
  run.track.platform_frame = platform_frame;
  for (int k = 0; k < 40; ++k) {
    run.track.time.push_back(0.3 + 0.011 * k);
    run.track.position.emplace_back(noise(random), noise(random));
    run.track.covariance.push_back(1e-12 * Eigen::Matrix2d::Identity());
  }
  return run;
}

TEST(Residuals, JacobianIsThatOfDifferences) {
  std::mt19937 random(3);
  Problem problem;
  using enum FitParameter;
  problem.free = {mu1, mu2, lag, delay, amplitude, angular_frequency, scale, tilt_x, tilt_y};
  problem.prior[tilt_x] = {0, 0.01};
  for (const double phi : {0.4, 2.0}) {
    problem.summary_runs.push_back(
        test::summary_run(test::scenario({}, phi, 1.1), 0.02, 0.1e-3));  // given as alpha, v
    problem.summary_runs.push_back(problem.summary_runs.back());         // seen in a recording
    problem.summary_runs.back().measured.given_as_velocity = false;
    problem.summary_runs.back().amplitude_from_track = true;
  }
  problem.summary_runs[2].scenario.drive.angular_frequency *= 1.1;
  problem.trajectory_runs = {track(test::scenario({}, 1, pi / 3), true, random),
                             track(test::scenario({}, 2, pi / 2), false, random)};
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  residuals.set_tolerance(1e-14);
  Eigen::VectorXd values(unknowns.size());
  values << 0.098, 0.013, 0.2, 1e-3, 0.27e-3, 62.1, 1.01, 1e-3, -2e-3, 0.03, -0.02;
  const auto at = residuals.at(values);
  ASSERT_TRUE(at);
  const Eigen::MatrixXd jacobian = at->jacobian(values.size());
  const Eigen::VectorXd units = unknowns.natural_units(values);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double h = 1e-6 * units(i);
    Eigen::VectorXd moved = values;
    moved(i) = values(i) + h;
    const auto up = residuals.at(moved, false);
    moved(i) = values(i) - h;
    const auto down = residuals.at(moved, false);
    ASSERT_TRUE(up && down);
    const Eigen::VectorXd slope = (up->residuals() - down->residuals()) / (2 * h);
    EXPECT_LT((slope - jacobian.col(i)).norm(), 1e-5 * jacobian.col(i).norm()) << "unknown " << i;
  }
}

Problem three_displacements() {
  Problem problem;
  using enum FitParameter;
  problem.free = {mu1, mu2, lag};
  for (const double phi : {0.4, 2.0, 4.0})
    problem.summary_runs.push_back(test::summary_run(test::scenario({}, phi, 1.1), 0.02, 0.1e-3));
  return problem;
}

TEST(Residuals, ScatterBetweenRunsIsAddedToTheirCovariance) {
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.summary_runs = {test::summary_run(test::scenario({}, 0.4, 1.1), 0.02, 0.1e-3)};
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  const Eigen::Matrix2d known = residuals.covariance(0);
  ExcessVariance scatter;
  scatter.runs = 3e-4;
  residuals.set_excess_variance(scatter);
  EXPECT_TRUE(residuals.covariance(0).isApprox(known + 9e-8 * Eigen::Matrix2d::Identity(), 1e-12));
}

// Noise of a point and scatter between points add up as variances: of independent points chi^2 falls by their
// ratio.
TEST(Residuals, ScatterBetweenPointsIsAddedToTheirNoise) {
  std::mt19937 random(5);
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.trajectory_runs = {track(test::scenario({}, 1, pi / 3), true, random)};  // sd 1 um
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  const Eigen::VectorXd values = unknowns.first_guess();
  const double alone = residuals.chi2(values);
  ExcessVariance scatter;
  scatter.trajectories = {{2e-6, 1}};
  residuals.set_excess_variance(scatter);
  EXPECT_NEAR(residuals.chi2(values) / alone, 1.0 / 5, 1e-3);
}

/// Values outside the model's domain are a region to avoid, with the reason.
TEST(Residuals, WithoutAMotionSayWhy) {
  const Problem problem = three_displacements();
  const Unknowns unknowns(problem);
  const Residuals residuals(unknowns);
  std::string why;
  EXPECT_TRUE(residuals.at(Eigen::Vector3d(0.1, 0.0125, 0.1), true, &why));
  EXPECT_EQ(why, "");
  EXPECT_FALSE(residuals.at(Eigen::Vector3d(0.1, -0.01, 0.1), true, &why));
  EXPECT_THAT(why, testing::HasSubstr("mu2"));
  EXPECT_EQ(residuals.chi2(Eigen::Vector3d(-0.1, 0.01, 0.1)), HUGE_VAL);
}

/// A search may stray to a w of a thousand times as many turns: of tracks, too, there is no motion then, not
/// gigabytes of it.
TEST(Residuals, TurnsBeyondAllSenseAreNoMotion) {
  std::mt19937 random(3);
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::angular_frequency};
  problem.trajectory_runs = {track(test::scenario({}, 1, pi / 3), true, random)};
  const Unknowns unknowns(problem);
  const Residuals residuals(unknowns);
  Eigen::VectorXd values = unknowns.first_guess();
  EXPECT_TRUE(residuals.at(values));
  values(1) *= 1e4;
  std::string why;
  EXPECT_FALSE(residuals.at(values, true, &why));
  EXPECT_THAT(why, testing::HasSubstr("steps"));
}

/// An error of the program must not look like a region to avoid.
TEST(Residuals, PassOnWhatIsNoPropertyOfTheParameters) {
  const Problem problem = three_displacements();
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns, 2);
  residuals.set_tolerance(0.5);  // the integrator refuses it
  EXPECT_THROW(residuals.at(Eigen::Vector3d(0.1, 0.0125, 0.1)), std::invalid_argument);
}

}  // namespace
}  // namespace tribotrack::fit::internal
