// Simulated campaigns that are fitted point by point.
#pragma once

#include <Eigen/Core>
#include <random>

#include "apps/bench/fit.h"
#include "model/trajectory.h"

namespace tribotrack::test {

/// The runs of bench::simulated_campaign() point by point: `points` of each, evenly spaced over the cycles,
/// with 1e-6 m of noise per axis.
inline fit::Problem simulated_tracks(const bench::FitTruth& truth, unsigned seed, std::size_t points,
                                     double cycles) {
  constexpr double kSigma = 1e-6;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, kSigma);
  fit::Problem problem = bench::simulated_campaign(truth, seed, cycles);
  for (const fit::SummaryRun& summary : problem.summary_runs) {
    fit::TrajectoryRun run;
    run.name = summary.name;
    run.scenario = summary.scenario;
    run.track.platform_frame = true;
    const model::Trajectory trajectory = model::integrate(run.scenario);
    for (std::size_t k = 0; k < points; ++k) {
      const double time = trajectory.end_time() * static_cast<double>(k) / static_cast<double>(points - 1);
      run.track.time.push_back(time);
      run.track.position.push_back(trajectory.at(time).position +
                                   Eigen::Vector2d(noise(random), noise(random)));
      run.track.covariance.push_back(kSigma * kSigma * Eigen::Matrix2d::Identity());
    }
    problem.trajectory_runs.push_back(run);
  }
  problem.summary_runs.clear();
  return problem;
}

}  // namespace tribotrack::test
