// Whole tracks of laboratories that are not the model. They are drawn by a stepping of their own (implicit
// friction, midpoint), not by the program's integrators.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

struct Laboratory {
  double stribeck = 0, viscous = 0, tilt_x = 0;
  double drift = 0;  ///< m, sd per axis of a straight line's end: of the camera, not of the part
  int bad_run = -1;
  std::vector<double> friction = {};  ///< of each run, relative; empty: 1
};

constexpr double kSd = 3e-6;
const test::Truth kTruth{0.09, 0.015, 0.2};

TrackTable filmed(const Laboratory& lab, const model::Scenario& s, double factor, std::mt19937& random) {
  constexpr int kSteps = 4000, kSeen = 80;  // a turn
  const double w = s.drive.angular_frequency, g = s.drive.gravity, dt = 2 * pi / w / kSteps;
  const double fading = s.drive.amplitude * w / 4;
  std::normal_distribution<double> noise(0, kSd);
  TrackTable track;
  track.platform_frame = true;
  Vector2d x(0, 0), u(0, 0);
  for (int k = 0; k <= static_cast<int>(s.cycles) * kSteps; ++k) {
    if (k % (kSteps / kSeen) == 0) {
      track.frame.push_back(k);
      track.time.push_back(k * dt);
      track.position.emplace_back(x.x() + noise(random), x.y() + noise(random));
      track.covariance.push_back(kSd * kSd * Eigen::Matrix2d::Identity());
    }
    const double wt = (k + 0.5) * w * dt, speed = u.norm();
    const double into = wt - s.friction.phase - kTruth.lag;
    const bool open = into - 2 * pi * std::floor(into / (2 * pi)) < s.friction.pulse_width;
    const double mu = factor * (open ? kTruth.mu2 : kTruth.mu1) *
                          (1 + lab.stribeck * std::exp(-std::pow(speed / fading, 2))) +
                      lab.viscous * speed / g;
    const double most = mu * g * dt;
    const Vector2d push(w * w * s.drive.amplitude * std::cos(wt) + g * std::sin(lab.tilt_x),
                        w * w * s.drive.amplitude_y * std::cos(wt + s.drive.phase_shift));
    const Vector2d free = u + dt * push;
    Vector2d next = free.norm() <= most ? Vector2d(0, 0) : Vector2d(free * (1 - most / free.norm()));
    if (speed > 2 * most)
      for (int i = 0; i < 4; ++i) next = free - most * (0.5 * (u + next)).normalized();
    x += dt * 0.5 * (u + next);
    u = next;
  }
  const Vector2d drift = lab.drift / kSd * Vector2d(noise(random), noise(random));
  for (std::size_t i = 0; i < track.time.size(); ++i)
    track.position[i] += track.time[i] / track.time.back() * drift;
  return track;
}

FitResult fitted(const Laboratory& lab) {
  std::mt19937 random(3);
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  problem.conditions = {{FitParameter::tilt_x, 0.002, "test"},   {FitParameter::tilt_y, 0.002, "test"},
                        {FitParameter::stribeck, 0.1, "test"},   {FitParameter::viscous, 1, "test"},
                        {FitParameter::amplitude, 3e-6, "test"}, {FitParameter::phase_shift, 0.02, "test"}};
  for (int k = 0; k < 8; ++k) {
    TrajectoryRun run;
    run.name = "run" + std::to_string(k);
    run.scenario = test::scenario({}, k * pi / 4, k % 2 == 0 ? pi / 3 : pi / 2, 6);
    run.scenario.friction.lag = 0;
    model::Scenario truth = run.scenario;
    if (k == lab.bad_run) truth.friction.phase += 0.7;
    run.track =
        filmed(lab, truth, lab.friction.empty() ? 1 : lab.friction[static_cast<std::size_t>(k)], random);
    run.scenario.friction.nominal = run.scenario.friction.reduced = 0.05;
    problem.trajectory_runs.push_back(run);
  }
  return estimate(problem, {.threads = 2, .next_experiment = false});
}

void expect_truth(const FitResult& result) {
  const double truths[] = {kTruth.mu1, kTruth.mu2, kTruth.lag};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(result.parameters[i].estimate, truths[i], 4 * result.parameters[i].sd + 1e-4 * truths[i])
        << result.full_report();
}

TEST(TracksOfLaboratories, FrictionThatDependsOnSpeedIsCounted) {
  for (const Laboratory& lab : {Laboratory{}, {.stribeck = 0.3}, {.viscous = 2}, {.tilt_x = 5e-3}}) {
    const FitResult result = fitted(lab);
    EXPECT_NE(result.verdict, Use::do_not_use) << result.full_report();
    EXPECT_GT(result.p_value, 1e-3);
    expect_truth(result);
    EXPECT_LT(result.parameters[0].sd, 1e-3 * kTruth.mu1);
    EXPECT_EQ(result.mu_of_speed.empty(), lab.stribeck == 0 && lab.viscous == 0) << result.full_report();
  }
}

TEST(TracksOfLaboratories, ABadRunIsLeftOutByName) {
  const FitResult result = fitted({.bad_run = 2});
  ASSERT_EQ(result.quoted_under.size(), 1U) << result.full_report();
  EXPECT_NE(result.quoted_under[0].find("'run2'"), std::string::npos) << result.quoted_under[0];
  EXPECT_EQ(result.explanations.front().name, "bad_run");
  EXPECT_LT(result.p_value, 1e-3);
  expect_truth(result);
}

TEST(TracksOfLaboratories, FrictionThatDiffersFromRunToRunIsCounted) {
  const FitResult result = fitted({.friction = {1.02, 0.98, 1.01, 0.97, 1.03, 0.99, 1.02, 0.98}});
  ASSERT_FALSE(result.explanations.empty()) << result.full_report();
  EXPECT_EQ(result.explanations.front().name, "run_scatter");
  EXPECT_TRUE(result.explanations.front().explains);
  EXPECT_NEAR(result.explanations.front().size, 2.2, 0.6);  // per cent
  expect_truth(result);
  EXPECT_GT(result.parameters[0].sd, 0.005 * kTruth.mu1);
}

TEST(TracksOfLaboratories, ADriftOfThePictureIsNoFriction) {
  const FitResult result = fitted({.tilt_x = 5e-3, .drift = 10e-6});
  EXPECT_TRUE(result.quoted_under.empty()) << result.full_report();
  EXPECT_NEAR(result.correlated_errors.drift, 10e-6, 5e-6);
  expect_truth(result);
  EXPECT_LT(result.parameters[0].sd, 1e-3 * kTruth.mu1);
}

}  // namespace
}  // namespace tribotrack::fit
