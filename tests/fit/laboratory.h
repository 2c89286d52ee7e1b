// A laboratory that is not the model: Moreau's time stepping (J. J. Moreau, Unilateral contact and dry
// friction in finite freedom dynamics, 1988) of a part on a platform that may be tilted, elliptic, or shaken
// out of phase, under friction that may depend on speed and the run.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "fit/problem.h"

namespace tribotrack::test {

struct Laboratory {
  double mu1 = 0.1, mu2 = 0.02, lag = 0.2;
  // What the campaign does not say.
  double tilt_x = 0, tilt_y = 0;        ///< rad
  double ratio = 1, epsilon_error = 0;  ///< A_y/A about their mean; rad
  double stribeck = 0, viscous = 0;     ///< relative, fading by A w/4; 1/s
  double scatter = 0;                   ///< relative, of both from run to run
  int bad_run = -1;                     ///< whose phi was 0.7 rad more than it says
};

/// Displacement of one run, m.
inline Eigen::Vector2d stepped(const Laboratory& lab, const model::Scenario& s, double mu1, double mu2) {
  constexpr int kSteps = 1000;  // a turn
  const double w = s.drive.angular_frequency, g = s.drive.gravity, a = s.drive.amplitude;
  const double dt = 2 * std::numbers::pi / w / kSteps, fading = a * w / 4;
  const double on = s.friction.phase + lab.lag, width = s.friction.pulse_width;
  // Integral of the share of mu2 in mu over wt.
  const auto open = [&](double wt) {
    const double turns = std::floor((wt - on) / (2 * std::numbers::pi));
    const double into = wt - on - 2 * std::numbers::pi * turns;
    const auto pulse = [&](double q) { return std::clamp(q, 0.0, width); };
    return turns * width + pulse(into) + pulse(into + 2 * std::numbers::pi) - width;
  };
  Eigen::Vector2d x = Eigen::Vector2d::Zero(), u = x;
  const Eigen::Vector2d pull(g * std::sin(lab.tilt_x), g * std::sin(lab.tilt_y));
  double before = open(0);
  for (int k = 0; k < static_cast<int>(s.cycles) * kSteps; ++k) {
    const double wt = (k + 0.5) * w * dt, after = open((k + 1) * w * dt);
    const double reduced = (after - before) / (w * dt), speed = u.norm();
    before = after;
    const Eigen::Vector2d push =
        pull +
        w * w * a / std::sqrt(lab.ratio) *
            Eigen::Vector2d(std::cos(wt), lab.ratio * std::cos(wt + s.drive.phase_shift + lab.epsilon_error));
    const double mu =
        (mu1 + (mu2 - mu1) * reduced) * (1 + lab.stribeck * std::exp(-speed * speed / (fading * fading))) +
        lab.viscous * speed / g;
    const double most = mu * g * dt;
    const Eigen::Vector2d free = u + dt * push;
    Eigen::Vector2d next =
        free.norm() <= most ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(free * (1 - most / free.norm()));
    if (speed > 2 * most)  // of second order where it slides: along the mean velocity
      for (int i = 0; i < 4; ++i) next = free - most * (0.5 * (u + next)).normalized();
    x += dt * 0.5 * (u + next);
    u = next;
  }
  return x;
}

/// Eight phi at one width, six widths at one phi, in an order of chance; as the campaign believes them.
inline fit::Problem campaign(const Laboratory& lab, double alpha_sd, double v_sd, std::mt19937& random) {
  std::normal_distribution<double> normal;
  fit::Problem problem;
  problem.free = {fit::FitParameter::mu1, fit::FitParameter::mu2, fit::FitParameter::lag};
  for (int k = 0; k < 14; ++k) {
    fit::SummaryRun run;
    run.name = "run" + std::to_string(k);
    model::Scenario& s = run.scenario;
    s.cycles = 20;
    s.friction.phase = k < 8 ? k * std::numbers::pi / 4 : 0;
    s.friction.pulse_width =
        k < 8 ? std::numbers::pi / 3 : (k - 7) * std::numbers::pi / 6 + (k > 8 ? 0.5 : 0);
    model::Scenario truth = s;
    if (k == lab.bad_run) truth.friction.phase += 0.7;
    const double run_factor = 1 + lab.scatter * normal(random);
    const Eigen::Vector2d moved = stepped(lab, truth, lab.mu1 * run_factor, lab.mu2 * run_factor);
    const double duration = s.end_time(), v = moved.norm() / duration;
    run.measured = fit::displacement_from_alpha_v(
        {std::atan2(moved.y(), moved.x()) + alpha_sd * normal(random), alpha_sd},
        {v * (1 + v_sd * normal(random)), v_sd * v}, s.drive.angular_frequency, 20);
    problem.summary_runs.push_back(run);
  }
  return problem;
}

}  // namespace tribotrack::test
