#include "fit/measurement.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace tribotrack::fit {
namespace {

constexpr double pi = std::numbers::pi;
using Curve = std::function<Eigen::Vector2d(double)>;

TrackTable sample(const Curve& curve, double rate, double duration, double sigma, unsigned seed = 0,
                  double start = 0) {
  TrackTable track;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sigma > 0 ? sigma : 1);
  const Eigen::Vector2d origin = curve(start);
  for (int k = 0; k / rate <= duration + 1e-12; ++k) {
    const double t = start + k / rate;
    track.frame.push_back(k);
    track.time.push_back(t);
    Eigen::Vector2d p = curve(t) - origin;
    if (sigma > 0) p += Eigen::Vector2d(noise(random), noise(random));
    track.position.push_back(p);
    track.covariance.push_back(Eigen::Matrix2d::Identity() * sigma * sigma);
  }
  return track;
}

void erase_rows(TrackTable& track, std::size_t from, std::size_t to) {
  const auto cut = [&](auto& column) {
    if (!column.empty()) column.erase(column.begin() + long(from), column.begin() + long(to));
  };
  cut(track.frame), cut(track.time), cut(track.position), cut(track.covariance), cut(track.marker),
      cut(track.marker_sigma);
}

// x = drift + a circle: over whole cycles only the drift is left, whatever the frame grid.
TEST(Displacement, WholeCyclesCancelThePeriodicPart) {
  const double w = 62.8, r = 0.28e-3;
  const Eigen::Vector2d drift(3e-3, -1.5e-3);
  for (const double rate : {487.3, 1000.0, 2111.0}) {
    const auto track = sample(
        [&](double t) {
          return Eigen::Vector2d(drift * t + r * Eigen::Vector2d(std::cos(w * t), std::sin(w * t)));
        },
        rate, 2.2, 0);
    const auto d = measure_displacement(track, {w, 0}, 20);
    EXPECT_EQ(d.cycles, 20);
    EXPECT_DOUBLE_EQ(d.duration, 20 * 2 * pi / w);
    EXPECT_LT((d.vector - drift * d.duration).norm(), 2e-8) << rate;  // a thousandth of a pixel of 20 um
    ASSERT_TRUE(d.alpha);
    EXPECT_NEAR(d.alpha->value, 2 * pi - std::atan(0.5), 1e-5);
    EXPECT_NEAR(d.mean_velocity.value, drift.norm(), 1e-7);
  }
}

TEST(Displacement, TakesAsManyCyclesAsThereAre) {
  const auto track = sample([](double t) { return Eigen::Vector2d(t, 0); }, 100, 0.75, 1e-6);
  EXPECT_EQ(measure_displacement(track, {2 * pi / 0.1, 0}, 20).cycles, 7);
  EXPECT_EQ(measure_displacement(track, {2 * pi / 0.25, 0}, 20).cycles, 3);  // ends on the last frame
  EXPECT_EQ(measure_displacement(track, {2 * pi / 0.1, 0}, 5).cycles, 5);
}

TEST(Displacement, StartsAtTheFirstTrackedPoint) {
  const auto track = sample([](double t) { return Eigen::Vector2d(t * t, 0); }, 200, 1, 1e-7, 1, 0.3);
  const auto d = measure_displacement(track, {2 * pi / 0.31, 0}, 1);
  EXPECT_NEAR(d.vector.x(), 0.61 * 0.61 - 0.09, 1e-6);
}

TEST(Displacement, UncertaintyOfWMovesTheEnd) {
  // Straight motion at u: an error dw moves the end by -u T dw / w.
  const auto track = sample([](double t) { return Eigen::Vector2d(2e-3 * t, 1e-3 * t); }, 500, 2.1, 0);
  const double w = 62.8, sd = 0.05;
  const auto d = measure_displacement(track, {w, sd}, 20);
  const double scale = d.duration * sd / w;
  EXPECT_NEAR(d.covariance(0, 0), std::pow(2e-3 * scale, 2), 1e-15);
  EXPECT_NEAR(d.covariance(0, 1), 2e-6 * scale * scale, 1e-15);
  EXPECT_NEAR(d.mean_velocity.sd, 0, 1e-9);  // of steady motion, v does not care where the end is
}

TEST(Displacement, LostFramesNearTheEndWidenTheCovarianceOrCostACycle) {
  const double w = 2 * pi / 0.1, r = 0.28e-3;
  const Curve curve = [&](double t) {
    return Eigen::Vector2d(1e-3 * t + r * std::cos(w * t), r * std::sin(w * t));
  };
  auto few = sample(curve, 997, 1.05, 1e-7);
  const double whole = measure_displacement(few, {w, 0}, 10).covariance.trace();
  erase_rows(few, 992, 1002);  // 10 ms around the end at 1.0 s
  const auto d = measure_displacement(few, {w, 0}, 10);
  EXPECT_EQ(d.cycles, 10);
  EXPECT_GT(d.covariance.trace(), whole);
  EXPECT_LT(std::abs(d.vector.x() - 1e-3), 4 * std::sqrt(d.covariance(0, 0)));
  auto many = sample(curve, 997, 1.05, 1e-7);
  erase_rows(many, 980, 1015);  // 35 ms: more than a sixth of a cycle
  EXPECT_EQ(measure_displacement(many, {w, 0}, 10).cycles, 9);
}

TEST(Displacement, AlphaIsEmptyBelowThreeSigma) {
  Displacement d;
  d.duration = 2;
  d.vector = {2.9e-6, 0};
  d.covariance = Eigen::Matrix2d::Identity() * 1e-12;
  derive_alpha_and_v(d);
  EXPECT_FALSE(d.alpha);
  d.vector = {0, -3.1e-6};
  derive_alpha_and_v(d);
  ASSERT_TRUE(d.alpha);
  EXPECT_DOUBLE_EQ(d.alpha->value, 1.5 * pi);
  EXPECT_NEAR(d.alpha->sd, 1 / 3.1, 1e-12);
  EXPECT_DOUBLE_EQ(d.mean_velocity.value, 1.55e-6);
  EXPECT_DOUBLE_EQ(d.mean_velocity.sd, 0.5e-6);
}

TEST(Displacement, AlphaAndVMeasuredElsewhereComeBack) {
  for (const double alpha : {0.0, 1.0, 3.5, 6.2831}) {
    const auto d = displacement_from_alpha_v({alpha, 0.01}, {2e-3, 5e-5}, 62.8, 20);
    ASSERT_TRUE(d.alpha);
    EXPECT_NEAR(d.alpha->value, alpha, 1e-14);
    EXPECT_NEAR(d.alpha->sd, 0.01, 1e-12);
    EXPECT_NEAR(d.mean_velocity.value, 2e-3, 1e-17);
    EXPECT_NEAR(d.mean_velocity.sd, 5e-5, 1e-16);
  }
  const auto still = displacement_from_alpha_v({1, 0.5}, {0, 5e-5}, 62.8, 20);
  EXPECT_FALSE(still.alpha);
  EXPECT_NEAR(still.covariance(0, 0), still.covariance(1, 1), 1e-18);
  EXPECT_THROW(displacement_from_alpha_v({1, 0}, {1e-3, 5e-5}, 62.8, 20), DataError);
}

TEST(Displacement, RefusesWhatCannotBeUsed) {
  const auto track = sample([](double t) { return Eigen::Vector2d(t, 0); }, 100, 0.75, 1e-6);
  EXPECT_THROW(measure_displacement(track, {2 * pi, 0}, 20), DataError);  // less than one cycle
  EXPECT_THROW(measure_displacement(track, {0, 0}, 20), DataError);
  EXPECT_THROW(measure_displacement(track, {NAN, 0}, 20), DataError);
  EXPECT_THROW(measure_displacement(track, {62.8, 0}, 0), DataError);
  EXPECT_THROW(measure_displacement(TrackTable{}, {62.8, 0}, 20), DataError);
  auto bad = track;
  bad.time[5] = bad.time[4];
  EXPECT_THROW(measure_displacement(bad, {62.8, 0}, 2), DataError);
  bad = track;
  bad.position[7].x() = NAN;
  EXPECT_THROW(measure_displacement(bad, {62.8, 0}, 2), DataError);
}

TrackTable marker_track(double a, double b, double w, double phase, double epsilon, double rate,
                        double duration, double sigma, unsigned seed) {
  TrackTable track = sample([](double) { return Eigen::Vector2d(0, 0); }, rate, duration, 0);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  for (const double t : track.time) {
    track.marker.push_back(
        Eigen::Vector2d(a * std::cos(w * t + phase), b * std::cos(w * t + phase + epsilon)) +
        sigma * Eigen::Vector2d(noise(random), noise(random)) + Eigen::Vector2d(1e-3 + 1e-6 * t, -2e-3));
    track.marker_sigma.push_back(sigma > 0 ? sigma : 1e-9);
    track.exposure = 1e-6;
  }
  return track;
}

TEST(PlatformMotion, ExactSinesComeBackExactly) {
  for (const double epsilon : {pi / 2, -pi / 2, 0.3, pi, -2.5})
    for (const double phase : {0.1, 3.0, 6.2}) {
      const auto motion =
          measure_platform_motion(marker_track(0.28e-3, 0.25e-3, 62.8, phase, epsilon, 500, 2.1, 0, 1));
      ASSERT_TRUE(motion);
      EXPECT_NEAR(motion->amplitude.value, 0.28e-3, 1e-12);
      EXPECT_NEAR(motion->amplitude_y.value, 0.25e-3, 1e-12);
      EXPECT_NEAR(motion->angular_frequency.value, 62.8, 1e-8);
      EXPECT_NEAR(motion->phase_at_zero.value, phase, 1e-8);
      EXPECT_NEAR(std::remainder(motion->phase_shift.value - epsilon, 2 * pi), 0, 1e-8);
      EXPECT_EQ(motion->clockwise, std::sin(motion->phase_shift.value) > 0);
    }
}

TEST(PlatformMotion, StatedUncertaintyIsTheScatter) {
  double chi2 = 0;
  const int trials = 100;
  for (int i = 0; i < trials; ++i) {
    const auto m = measure_platform_motion(
        marker_track(0.28e-3, 0.28e-3, 62.8, 2, pi / 2, 250, 2, 2e-6, 99 + unsigned(i)));
    ASSERT_TRUE(m);
    const auto pull = [](const Estimate& e, double truth) { return std::pow((e.value - truth) / e.sd, 2); };
    chi2 += pull(m->amplitude, 0.28e-3) + pull(m->amplitude_y, 0.28e-3) + pull(m->angular_frequency, 62.8) +
            pull(m->phase_shift, pi / 2) + pull(m->phase_at_zero, 2);
  }
  EXPECT_NEAR(chi2 / (5 * trials), 1, 0.25);
}

TEST(PlatformMotion, LargerResidualsThanSigmaAreBelieved) {
  auto track = marker_track(0.28e-3, 0.28e-3, 62.8, 2, pi / 2, 250, 2, 2e-6, 5);
  const double honest = measure_platform_motion(track)->angular_frequency.sd;
  for (double& sigma : track.marker_sigma) sigma /= 10;
  EXPECT_NEAR(measure_platform_motion(track)->angular_frequency.sd, honest, 0.15 * honest);
  for (double& sigma : track.marker_sigma) sigma *= 50;
  EXPECT_NEAR(measure_platform_motion(track)->angular_frequency.sd, 5 * honest, honest);
}

TEST(PlatformMotion, OneDimensionalMotion) {
  const auto along_x = measure_platform_motion(marker_track(0.3e-3, 0, 40, 1, 0, 300, 2, 1e-6, 3));
  ASSERT_TRUE(along_x);
  EXPECT_NEAR(along_x->amplitude.value, 0.3e-3, 1e-6);
  EXPECT_NEAR(along_x->phase_at_zero.value, 1, 0.01);
  EXPECT_FALSE(along_x->clockwise);
  const auto along_y = measure_platform_motion(marker_track(0, 0.3e-3, 40, 1, 0.5, 300, 2, 1e-6, 3));
  ASSERT_TRUE(along_y);
  EXPECT_NEAR(along_y->phase_at_zero.value + along_y->phase_shift.value, 1.5, 0.01);
}

TEST(PlatformMotion, GapsDoNotSlipCycles) {
  auto track = marker_track(0.28e-3, 0.28e-3, 62.8, 2, pi / 2, 1000, 12, 2e-6, 5);
  erase_rows(track, 300, 1400);
  erase_rows(track, 6000, 6900);
  const auto m = measure_platform_motion(track);
  ASSERT_TRUE(m);
  EXPECT_NEAR(m->angular_frequency.value, 62.8, 5 * m->angular_frequency.sd);
  EXPECT_LT(m->angular_frequency.sd, 1e-4);
}

TEST(PlatformMotion, ABreakIsFoundWhereFramesAreMissingInSilenceOrTheCameraIsKnocked) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto whole = marker_track(0.28e-3, 0.25e-3, 62.8, 0.3 * seed, pi / 2, 500, 0.5, 2e-6, seed);
    const std::size_t n = whole.marker.size(), row = 20 + 10 * seed;
    EXPECT_FALSE(measure_platform_motion(whole)->broken) << seed;
    auto shorter = whole, knocked = whole;
    shorter.marker.erase(shorter.marker.begin() + static_cast<long>(row));
    shorter.time.pop_back(), shorter.frame.pop_back(), shorter.position.pop_back();
    shorter.covariance.pop_back(), shorter.marker_sigma.pop_back();
    const auto missing = measure_platform_motion(shorter)->broken;
    ASSERT_TRUE(missing) << seed;
    EXPECT_NEAR(static_cast<double>(missing->row), static_cast<double>(row), 2);
    EXPECT_NEAR(missing->ahead, 1 / 500.0, 0.1 / 500);
    EXPECT_LT(missing->moved.norm(), 4e-6);
    const Eigen::Vector2d by(20e-6, -10e-6);
    for (std::size_t i = row; i < n; ++i) knocked.marker[i] += by;
    const auto moved = measure_platform_motion(knocked)->broken;
    ASSERT_TRUE(moved) << seed;
    EXPECT_NEAR(static_cast<double>(moved->row), static_cast<double>(row), 1);
    EXPECT_LT((moved->moved - by).norm(), 4e-6);
    EXPECT_NEAR(moved->ahead, 0, 0.1 / 500);
  }
}

// What is wrong all along, or bit by bit, is no break.
TEST(PlatformMotion, ADriftAndHarmonicsAreNoBreak) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    auto drifting = marker_track(0.28e-3, 0.28e-3, 62.8, 1, pi / 2, 500, 2, 2e-6, seed), eccentric = drifting,
         noisy = drifting;
    const auto slow = marker_track(0.28e-3, 0.28e-3, 62.8, 1, pi / 2, 500, 2, 0, seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 3e-6);
    Eigen::Vector2d walk = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < slow.time.size(); ++i) {
      const double t = slow.time[i], phase = 62.8 * t + 1 + 0.5 * t * t;
      drifting.marker[i] = 0.28e-3 * Eigen::Vector2d(std::cos(phase), -std::sin(phase));
      eccentric.marker[i] += 0.03e-3 * Eigen::Vector2d(std::cos(2 * phase), std::sin(2 * phase));
      walk = 0.98 * walk + Eigen::Vector2d(normal(random), normal(random));
      noisy.marker[i] += walk;
    }
    for (const auto* track : {&drifting, &eccentric, &noisy})
      EXPECT_FALSE(measure_platform_motion(*track)->broken) << seed;
  }
}

TEST(PlatformMotion, RestIsNoMotion) {
  EXPECT_FALSE(measure_platform_motion(marker_track(0, 0, 40, 1, 0.5, 300, 2, 1e-6, 3)));
  EXPECT_FALSE(measure_platform_motion(marker_track(0.5e-6, 0.5e-6, 40, 1, 0.5, 300, 2, 1e-6, 3)));
  EXPECT_FALSE(measure_platform_motion(TrackTable{}));
}

}  // namespace
}  // namespace tribotrack::fit
