#include "fit/motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace tribotrack::fit {
namespace {

using Path = std::function<Eigen::Vector2d(double)>;

constexpr double kNoise = 5e-6, kStep = 2e-3, kW = 62.8, kA = 0.28e-3;

TrackTable track_of(const Path& path, int points, double noise = kNoise, double told = 1, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<> error(0, 1);
  TrackTable track;
  for (int k = 0; k < points; ++k) {
    track.frame.push_back(k);
    track.time.push_back(k * kStep);
    track.position.emplace_back(path(k * kStep) + noise * Eigen::Vector2d(error(random), error(random)));
    track.covariance.push_back(std::pow(told * noise, 2) * Eigen::Matrix2d::Identity());
  }
  return track;
}

Path circling(double drift) {
  return [=](double t) {
    return Eigen::Vector2d(kA * std::cos(kW * t) + drift * t, kA * std::sin(kW * t) + 0.3 * drift * t);
  };
}

/// From rest after `before`, braked from u by a until it stops.
Path sliding(double u, double a, double before = 0) {
  return [=](double t) {
    const double s = std::clamp(t - before, 0.0, u / a);
    return Eigen::Vector2d((u * s - a * s * s / 2) * Eigen::Vector2d(0.8, -0.6));
  };
}

MotionKind kind_of(const TrackTable& track) {
  return shown_motion(track).kind;
}

TEST(ShownMotion, ADriveIsSeenWithoutAMark) {
  for (const double drift : {0.0, 2e-3, 0.04}) {
    const ShownMotion shown = shown_motion(track_of(circling(drift), 1000));
    ASSERT_EQ(shown.kind, MotionKind::driven);
    const Oscillation& o = *shown.oscillation;
    EXPECT_NEAR(o.angular_frequency.value, kW, 4 * o.angular_frequency.sd);
    EXPECT_LT(o.angular_frequency.sd, 1e-3 * kW);
    EXPECT_NEAR(o.cycles, kW * 999 * kStep / 6.283185307, 0.01);
    EXPECT_NEAR(o.major, kA, 0.02 * kA);
    EXPECT_NEAR(o.minor, kA, 0.02 * kA);
  }
}

TEST(ShownMotion, ADriveIsSeenInAFewCyclesInNoiseAndAtAnyFrameRate) {
  EXPECT_EQ(kind_of(track_of(circling(2e-3), 150)), MotionKind::driven) << "three cycles";
  EXPECT_EQ(kind_of(track_of(circling(2e-3), 1000, kA)), MotionKind::driven) << "noise as large as A";
  TrackTable fast = track_of(circling(2e-3), 30000);
  for (double& time : fast.time) time /= 20;
  EXPECT_EQ(kind_of(fast), MotionKind::driven) << "15 cycles of 2000 frames each at a higher w";
}

TEST(ShownMotion, APendulumSwings) {
  const auto swinging = [](double decay) {
    return
        [decay](double t) { return Eigen::Vector2d(0.05 * std::cos(40 * t) * std::exp(-decay * t), 0.01); };
  };
  for (const double decay : {0.0, 0.3, 2.0}) {
    const ShownMotion shown = shown_motion(track_of(swinging(decay), 800));
    EXPECT_EQ(shown.kind, MotionKind::swinging) << decay;
    EXPECT_NEAR(shown.oscillation->angular_frequency.value, 40, 0.5);
  }
}

TEST(ShownMotion, ASlideIsBrakedAndBackwardsItIsAnIncline) {
  for (const int points : {120, 250, 400}) {  // before it stops, just after, long after
    TrackTable track = track_of(sliding(0.6, 1.5, 0.02), points);
    const ShownMotion slide = shown_motion(track);
    ASSERT_EQ(slide.kind, MotionKind::slide) << points;
    EXPECT_NEAR(slide.braking->deceleration, 1.5, 0.08);
    EXPECT_NEAR(slide.braking->speed, 0.6, 0.04);
    std::ranges::reverse(track.position);
    const ShownMotion incline = shown_motion(track);
    ASSERT_EQ(incline.kind, MotionKind::incline) << points;
    EXPECT_NEAR(incline.braking->deceleration, -1.5, 0.08);
  }
}

TEST(ShownMotion, ACameraThatVibratesSeesASlideAndRestAllTheSame) {
  const Path slide = sliding(0.6, 1.5, 0.02);
  const auto shaken = [](const Path& path, double a) {
    return [=](double t) { return Eigen::Vector2d(path(t) + a * Eigen::Vector2d(std::cos(314 * t), 0)); };
  };
  for (const double a : {0.3 * kNoise, 3 * kNoise, 50 * kNoise})
    EXPECT_EQ(kind_of(track_of(shaken(slide, a), 400)), MotionKind::slide) << a;
  const Path rest = [](double) { return Eigen::Vector2d(0.01, 0); };
  EXPECT_EQ(kind_of(track_of(shaken(rest, 0.5 * kNoise), 2000)), MotionKind::at_rest);
  EXPECT_EQ(kind_of(track_of(circling(0.04), 3000)), MotionKind::driven) << "a long way at an even speed";
}

TEST(ShownMotion, FrictionThatRisesWithSpeedStillBrakesASlide) {
  const double a = 1.86, c = 0.84, u = 1;  // the real slides' du/dt = -(a + c u)
  const auto path = [&](double t) {
    const double s = std::min(t, std::log1p(c * u / a) / c);
    return Eigen::Vector2d(((u + a / c) * (1 - std::exp(-c * s)) - a * s) / c, 0);
  };
  EXPECT_EQ(kind_of(track_of(path, 300)), MotionKind::slide);
  const auto in_oil = [](double t) { return Eigen::Vector2d(0.12 * (1 - std::exp(-5 * t)), 0); };
  EXPECT_NE(kind_of(track_of(in_oil, 500)), MotionKind::slide) << "braked by its speed alone, it never stops";
}

TEST(ShownMotion, WhatGoesOnEvenlyAndStopsAtOnceIsPulled) {
  EXPECT_EQ(kind_of(track_of([](double t) { return Eigen::Vector2d(0.1 * t, 0); }, 400)), MotionKind::pulled);
  const auto stops = [](double t) { return Eigen::Vector2d(0.1 * std::min(t, 0.6), 0); };
  EXPECT_EQ(kind_of(track_of(stops, 400)), MotionKind::pulled);
  const auto winched = [](double t) {  // let in and out by a clutch, with a ripple of its own
    return Eigen::Vector2d(0.1 * (t - 0.05 * std::sin(14 * t)) / (1 + std::exp(-30 * (t - 0.1))), 0);
  };
  EXPECT_EQ(kind_of(track_of(winched, 400)), MotionKind::pulled);
}

TEST(ShownMotion, NoiseIsRestAndAWalkIsNothing) {
  EXPECT_EQ(kind_of(track_of([](double) { return Eigen::Vector2d(0.01, 0.02); }, 500, 0)),
            MotionKind::at_rest)
      << "places in whole pixels";
  for (unsigned seed = 0; seed < 20; ++seed) {
    const TrackTable rest =
        track_of([](double) { return Eigen::Vector2d(0.01, 0.02); }, 500, kNoise, 1, seed);
    EXPECT_EQ(kind_of(rest), MotionKind::at_rest) << seed;
    TrackTable walk = rest;
    for (std::size_t k = 1; k < walk.position.size(); ++k)
      walk.position[k] = walk.position[k - 1] + 100 * (rest.position[k] - Eigen::Vector2d(0.01, 0.02));
    const MotionKind kind = kind_of(walk);
    EXPECT_TRUE(kind == MotionKind::unknown || kind == MotionKind::pulled) << seed << to_string(kind);
  }
}

/// Turned, in another unit of length and time, or with sds told wrong it is the same motion.
TEST(ShownMotion, FollowsTheUnits) {
  for (const Path& path : {circling(2e-3), sliding(0.6, 1.5, 0.02)}) {
    const TrackTable track = track_of(path, 400);
    const ShownMotion as_it_is = shown_motion(track);
    TrackTable other = track;
    constexpr double kLength = 37, kTime = 0.013;
    for (double& time : other.time) time *= kTime;
    for (Eigen::Vector2d& p : other.position) p = kLength * (Eigen::Rotation2Dd(1.1) * p);
    for (Eigen::Matrix2d& c : other.covariance) c *= kLength * kLength;
    const ShownMotion turned = shown_motion(other);
    EXPECT_EQ(turned.kind, as_it_is.kind);
    if (turned.oscillation) {
      EXPECT_NEAR(kTime * turned.oscillation->angular_frequency.value,
                  as_it_is.oscillation->angular_frequency.value, 1e-4);
    } else {
      EXPECT_NEAR(turned.braking->deceleration * kTime * kTime / kLength, as_it_is.braking->deceleration,
                  1e-6);
    }
    for (Eigen::Matrix2d& c : other.covariance) c /= 9;
    EXPECT_EQ(kind_of(other), as_it_is.kind);
  }
}

}  // namespace
}  // namespace tribotrack::fit
