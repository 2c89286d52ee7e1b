// Campaigns with known truth, made by an independent integrator.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "apps/bench/peers.h"
#include "fit/problem.h"

namespace tribotrack::test {

struct Truth {
  double mu1 = 0.1, mu2 = 0.0125, lag = 0.1;
};

inline model::Scenario scenario(const Truth& truth, double phi, double dtau, double cycles = 20) {
  model::Scenario s;
  s.friction = {truth.mu1, truth.mu2, phi, dtau, truth.lag};
  s.cycles = cycles;
  return s;
}

/// Where it ends, m: of a solution that shares nothing with the library's integrator.
inline Eigen::Vector2d displacement(const model::Scenario& truth) {
  return bench::extended_precision_reference(truth, 1e-11).position;
}

/// A run measured as alpha and v with the given sds; noise is drawn where `random` is given.
inline fit::SummaryRun summary_run(const model::Scenario& truth, double alpha_sd, double v_sd,
                                   std::mt19937* random = nullptr) {
  const double w = truth.drive.angular_frequency;
  const double duration = truth.cycles * 2 * std::numbers::pi / w;
  const Eigen::Vector2d d = displacement(truth);
  fit::SummaryRun run;
  run.name =
      "phi " + std::to_string(truth.friction.phase) + " dtau " + std::to_string(truth.friction.pulse_width);
  run.scenario = truth;
  run.scenario.friction.nominal = run.scenario.friction.reduced =
      0.05;  // nothing of the truth is handed over
  run.scenario.friction.lag = 0;
  double alpha = std::atan2(d.y(), d.x()), v = d.norm() / duration;
  run.measured =
      fit::displacement_from_alpha_v({alpha, alpha_sd}, {v, v_sd}, w, static_cast<int>(truth.cycles));
  if (random) {
    std::normal_distribution<double> normal;
    const Eigen::Matrix2d root = run.measured.covariance.llt().matrixL();
    run.measured.vector += root * Eigen::Vector2d(normal(*random), normal(*random));
    fit::derive_alpha_and_v(run.measured);
  }
  return run;
}

/// mu1, mu2 and the lag, to be fitted to runs measured so at these.
inline fit::Problem problem_of(const std::vector<model::Scenario>& scenarios, double alpha_sd, double v_sd,
                               std::mt19937* random = nullptr) {
  fit::Problem problem;
  problem.free = {fit::FitParameter::mu1, fit::FitParameter::mu2, fit::FitParameter::lag};
  for (const model::Scenario& scenario : scenarios)
    problem.summary_runs.push_back(summary_run(scenario, alpha_sd, v_sd, random));
  return problem;
}

/// The sentence that begins so; empty without.
inline std::string sentence_of(const std::string& beginning, const std::vector<std::string>& sentences) {
  for (const std::string& sentence : sentences)
    if (sentence.rfind(beginning, 0) == 0) return sentence;
  return "";
}

/// 8 values of phi at dtau = pi/3, then 6 values of dtau, k pi/6, at phi = 0.3.
inline std::vector<model::Scenario> fourteen(const Truth& truth) {
  std::vector<model::Scenario> runs;
  for (int k = 0; k < 8; ++k) runs.push_back(scenario(truth, k * std::numbers::pi / 4, std::numbers::pi / 3));
  for (int k = 1; k <= 6; ++k) runs.push_back(scenario(truth, 0.3, k * std::numbers::pi / 6));
  return runs;
}

}  // namespace tribotrack::test
