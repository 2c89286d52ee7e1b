#include "fit/slides/between_slides.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

using internal::shown_errors;
using internal::SlideResiduals;

constexpr double kStep = 0.004;

/// White noise and a stationary process of correlation time `time`, sds in m.
struct Noise {
  double white = 1e-4, slow = 0, time = 0.05;
};

std::vector<double> draw(const Noise& noise, std::size_t count, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double keep = std::exp(-kStep / noise.time);
  std::vector<double> e;
  double slow = noise.slow * normal(random);
  for (std::size_t k = 0; k < count; ++k) {
    e.push_back(slow + noise.white * normal(random));
    slow = keep * slow + std::sqrt(1 - keep * keep) * noise.slow * normal(random);
  }
  return e;
}

SlideResiduals residuals_of(const std::vector<double>& e) {
  SlideResiduals residuals{{}, e};
  for (std::size_t k = 0; k < e.size(); ++k) residuals.time.push_back(kStep * static_cast<double>(k));
  return residuals;
}

TrackTable track_told(double sd, const std::vector<SlowError>& slow = {}) {
  TrackTable track;
  track.covariance.assign(300, sd * sd * Eigen::Matrix2d::Identity());
  track.slow = slow;
  return track;
}

TEST(ErrorsShown, IsSeldomFoundInWhiteNoise) {
  std::mt19937 random(1);
  int found = 0;
  for (int k = 0; k < 1000; ++k)
    found += shown_errors(track_told(1e-4), residuals_of(draw({}, 300, random))).has_value();
  EXPECT_LE(found, 4);  // 1 expected
}

TEST(ErrorsShown, IsFoundWithItsSizeAndTime) {
  std::mt19937 random(2);
  const Noise noise{.white = 1e-4, .slow = 3e-4, .time = 0.04};
  const double told = std::hypot(noise.white, noise.slow);
  double own = 0, sd = 0, time = 0;
  for (int k = 0; k < 100; ++k) {
    const auto slow = shown_errors(track_told(told), residuals_of(draw(noise, 300, random)));
    ASSERT_TRUE(slow);
    own += slow->own_sd / 100;
    sd += slow->slow.sd / 100;
    time += slow->slow.time / 100;
  }
  // A slow error of this time makes steps of its own, and a mean is taken over one slide: to a third.
  EXPECT_NEAR(own, noise.white, 0.4 * noise.white);
  EXPECT_NEAR(sd, noise.slow, 0.3 * noise.slow);
  EXPECT_GT(time, 0.7 * noise.time);
  EXPECT_LT(time, 1.3 * noise.time);
}

TEST(ErrorsShown, OfATrackThatTellsItIsLeftAsItIs) {
  std::mt19937 random(3);
  const Noise noise{.white = 1e-4, .slow = 3e-4, .time = 0.04};
  const TrackTable track = track_told(std::hypot(noise.white, noise.slow), {{noise.slow, noise.time}});
  int found = 0;
  for (int k = 0; k < 100; ++k)
    found += shown_errors(track, residuals_of(draw(noise, 300, random))).has_value();
  EXPECT_LE(found, 3);
}

// A track whose sds are right in size and taken for independent: intervals of mu1 hold all the same.
TEST(ErrorsShown, KeepsIntervalsHonest) {
  constexpr int kSlides = 100;
  constexpr double kMu = 0.2, kGravity = 9.81;
  const Noise noise{.white = 2e-5, .slow = 1e-4, .time = 0.05};
  const double told = std::hypot(noise.white, noise.slow);
  std::mt19937 random(4);
  int inside = 0;
  for (int k = 0; k < kSlides; ++k) {
    TrajectoryRun run;
    run.name = "slide";
    run.free_slide = true;
    run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
    run.scenario.drive.gravity = kGravity;
    const std::vector<double> x = draw(noise, 150, random), y = draw(noise, 150, random);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double t = kStep * static_cast<double>(i);
      run.track.frame.push_back(static_cast<std::int64_t>(i));
      run.track.time.push_back(t);
      run.track.position.emplace_back(1.5 * t - 0.5 * kMu * kGravity * t * t + x[i], y[i]);
      run.track.covariance.emplace_back(told * told * Eigen::Matrix2d::Identity());
    }
    Problem problem;
    problem.free = {FitParameter::mu1};
    problem.trajectory_runs = {run};
    FitOptions options{.profiles = false, .next_experiment = false};
    const Interval ci = estimate(problem, options).parameters.front().ci95;
    inside += ci.low < kMu && kMu < ci.high;
  }
  EXPECT_GE(
      inside,
      78);  // of 95: a correlation of a tenth of the slide is told by few independent values. 34 without
}

}  // namespace
}  // namespace tribotrack::fit
