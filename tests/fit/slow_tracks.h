// Tracks with correlated errors of known size.
#pragma once

#include <cmath>
#include <random>

#include "fit/problem.h"
#include "model/trajectory.h"

namespace tribotrack::test {

/// Standard deviations per axis, m: of a straight drift and of a Brownian walk over `time`, of cos and sin of
/// wt, and of 2wt and 3wt.
struct SlowTruth {
  double drift = 0, walk = 0, circle = 0, overtones = 0;
  double time = 2;  ///< s
};

/// `rate` frames/s of the scenario's motion in the platform's frame; white noise `sigma` per axis and slow
/// errors drawn for this track.
inline fit::TrajectoryRun slow_track(const model::Scenario& truth, double rate, double sigma,
                                     const SlowTruth& slow, std::mt19937& random) {
  fit::TrajectoryRun run;
  run.name =
      "phi " + std::to_string(truth.friction.phase) + " dtau " + std::to_string(truth.friction.pulse_width);
  run.scenario = truth;
  run.scenario.friction.nominal = run.scenario.friction.reduced = 0.05;  // no hint of the truth
  run.scenario.friction.lag = run.scenario.drive.tilt_x = run.scenario.drive.tilt_y = 0;
  const auto motion = model::integrate(truth, {});
  std::normal_distribution<double> normal;
  const auto pair = [&] { return Eigen::Vector2d(normal(random), normal(random)); };
  const Eigen::Vector2d drift = slow.drift * pair();
  Eigen::Vector2d walk = Eigen::Vector2d::Zero(), sines[3][2];
  for (int order = 0; order < 3; ++order)
    for (auto& sine : sines[order]) sine = (order == 0 ? slow.circle : slow.overtones) * pair();
  for (int k = 0; k / rate <= truth.end_time(); ++k) {
    const double t = k / rate;
    if (k > 0) walk += slow.walk / std::sqrt(slow.time * rate) * pair();
    Eigen::Vector2d seen = motion.at(t).position + sigma * pair() + drift * t / slow.time + walk;
    for (int order = 0; order < 3; ++order) {
      const double angle = (order + 1) * truth.drive.angular_frequency * t;
      seen += std::cos(angle) * sines[order][0] + std::sin(angle) * sines[order][1];
    }
    run.track.time.push_back(t);
    run.track.frame.push_back(k);
    run.track.position.push_back(seen);
    run.track.covariance.push_back(sigma * sigma * Eigen::Matrix2d::Identity());
  }
  run.track.platform_frame = true;
  return run;
}

/// A process of this covariance by its own recursion, in x and in y, and the table says so.
inline void add_slow(fit::TrackTable& track, const fit::SlowError& slow, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto pair = [&] { return Eigen::Vector2d(normal(random), normal(random)); };
  Eigen::Vector2d error = slow.sd * pair();
  for (std::size_t i = 0; i < track.time.size(); ++i) {
    if (i > 0) {
      const double kept = std::exp(-(track.time[i] - track.time[i - 1]) / slow.time);
      error = kept * error + slow.sd * std::sqrt(1 - kept * kept) * pair();
    }
    track.position[i] += error;
    track.covariance[i] += slow.sd * slow.sd * Eigen::Matrix2d::Identity();
  }
  track.slow.push_back(slow);
}

}  // namespace tribotrack::test
