// A tracked point is the mean over its exposure.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fit/campaign.h"
#include "fit/estimate.h"
#include "model/trajectory.h"

namespace tribotrack::fit {
namespace {

using std::numbers::pi;

/// Mean of f over t - T/2 .. t + T/2 by the midpoints of 400 parts.
template <class F>
Eigen::Vector2d mean_over(double t, double exposure, const F& f) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  constexpr int parts = 400;
  for (int i = 0; i < parts; ++i) sum += f(t + exposure * ((i + 0.5) / parts - 0.5));
  return sum / parts;
}

TEST(Exposure, TheModelsPointsAreMeansOverIt) {
  model::Scenario scenario = test::scenario({0.1, 0.0125, 0.1}, 0.3, pi / 2, 6);
  const model::Trajectory motion = model::integrate(scenario);
  const double w = scenario.drive.angular_frequency, a = scenario.drive.amplitude, exposure = 0.6e-3;
  const double x = w * exposure;
  std::vector<double> times;
  for (int k = 1; k < 290; ++k) times.push_back(0.002 * k + 1e-5);
  Eigen::Matrix2Xd positions;
  motion.positions_at(times, exposure, positions, nullptr);
  // Where friction switches within the exposure its jump, (mu1 - mu2) g, counts by T^2/48 at most.
  const double at_switch = exposure * exposure / 48 * 0.0875 * 9.81;
  double largest = 0;
  int rough = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const Eigen::Vector2d mean =
        mean_over(times[k], exposure, [&](double t) { return motion.at(t).position; });
    const double error = (positions.col(static_cast<Eigen::Index>(k)) - mean).norm();
    EXPECT_LT(error, 1.2 * at_switch) << times[k];
    rough += error > 1e-3 * a * x * x / 24;
    largest = std::max(largest, (mean - motion.at(times[k]).position).norm());
  }
  EXPECT_LT(rough, 30);  // a switch every 0.05 s, each seen by one exposure or two
  EXPECT_GT(largest, 0.3 * a * x * x / 24);
}

/// Points of a run as its exposure makes them, without noise.
TrajectoryRun exposed(const model::Scenario& truth, double rate, double exposure, bool platform_frame) {
  TrajectoryRun run;
  run.name = "exposed";
  run.scenario = truth;
  run.scenario.friction.nominal = run.scenario.friction.reduced = 0.05;
  run.scenario.friction.lag = 0;
  model::Scenario longer = truth;
  longer.duration = truth.end_time() + exposure;
  const model::Trajectory motion = model::integrate(longer);
  for (int k = 1; k / rate <= truth.end_time(); ++k) {
    const double time = k / rate;
    run.track.time.push_back(time);
    run.track.frame.push_back(k);
    run.track.position.push_back(mean_over(time, exposure, [&](double t) -> Eigen::Vector2d {
      const Eigen::Vector2d own = motion.at(std::max(0.0, t)).position;
      return platform_frame
                 ? own
                 : Eigen::Vector2d(
                       own + truth.drive.displacement(truth.start_phase + truth.drive.angular_frequency * t));
    }));
    run.track.covariance.push_back(1e-16 * Eigen::Matrix2d::Identity());
  }
  run.track.time.insert(run.track.time.begin(), 0.0);
  run.track.frame.insert(run.track.frame.begin(), 0);
  run.track.position.insert(run.track.position.begin(), platform_frame
                                                            ? Eigen::Vector2d::Zero().eval()
                                                            : truth.drive.displacement(truth.start_phase));
  run.track.covariance.insert(run.track.covariance.begin(), Eigen::Matrix2d::Identity());
  run.track.platform_frame = platform_frame;
  run.track.exposure = exposure;
  return run;
}

TEST(Exposure, ToldItMovesNoParameter) {
  FitOptions options{
      .multi_starts = 2, .profiles = false, .next_experiment = false, .estimate_scatter = false};
  const model::Scenario truth = test::scenario({0.1, 0.0125, 0.1}, 0.3, pi / 2, 5);
  for (const bool platform_frame : {true, false}) {
    Problem problem;
    problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
    problem.trajectory_runs = {exposed(truth, 500, 1e-3, platform_frame)};
    const FitResult told = estimate(problem, options);
    problem.trajectory_runs[0].track.exposure = 0;
    const FitResult untold = estimate(problem, options);
    const double off = std::abs(told.value(FitParameter::mu1) - 0.1);
    EXPECT_LT(off, 2e-7) << platform_frame;
    EXPECT_NEAR(told.value(FitParameter::mu2), 0.0125, 2e-7) << platform_frame;
    EXPECT_GT(std::abs(untold.value(FitParameter::mu1) - 0.1), 10 * off) << platform_frame;
    EXPECT_GT(untold.chi2, 30 * told.chi2) << platform_frame;
  }
}

}  // namespace
}  // namespace tribotrack::fit
