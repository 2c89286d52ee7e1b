#include "vision/audit/audit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vision/audit/halves.h"
#include "vision/audit/synthetic_track.h"

namespace tribotrack::vision {
namespace {

using test::halves_of;
using test::kSigma;
using test::track_of;
using test::white;

double at_rest(int) {
  return 0;
}

auto noise(double factor) {
  return [factor](int, std::mt19937& random) { return white(random, factor * kSigma); };
}

auto halves_noise(double factor) {
  return [factor](std::int64_t, int, std::mt19937& random) { return white(random, factor * kSigma); };
}

TEST(Supported, DoubtIsNotWidenedAndALargeExcessIsTakenAsItIs) {
  EXPECT_EQ(supported({0.8, 0.01}), 1);
  EXPECT_EQ(supported({1.09, 0.05}), 1);
  EXPECT_NEAR(supported({4, 0.05}), 4, 0.01);
  EXPECT_NEAR(supported({1.1, 0.05}), 1, 1e-12);  // no step there
  std::mt19937 random(1);
  double mean = 0;
  for (int k = 0; k < 20000; ++k) mean += supported({1 + white(random, 0.1), 0.1}) / 20000;
  EXPECT_LT(mean, 1.003);
  EXPECT_GT(mean, 1);
}

TEST(Audit, RightStandardDeviationsStayAsTheyAre) {
  double widened = 0;
  constexpr int kTrials = 100;
  for (unsigned seed = 1; seed <= kTrials; ++seed) {
    Track track = track_of(400, seed, at_rest, noise(1));
    TrackSummary summary;
    const Audit found = audit(halves_of(400, seed, halves_noise(1)), track);
    EXPECT_NEAR(found.halves_x.value(), 1, 0.15);
    EXPECT_NEAR(found.high_frequency.value(), 1, 0.15);
    apply(found, track, summary);
    widened += track.points[7].sigma_x / kSigma / kTrials;
    EXPECT_TRUE(summary.warnings.empty());
  }
  EXPECT_GE(widened, 1);
  EXPECT_LT(widened, 1.01);
}

TEST(Audit, NothingReportsLessThanItFinds) {
  Track track = track_of(400, 1, at_rest, noise(1));
  for (TrackPoint& p : track.points) p.rho_xy = 0.4;
  TrackSummary summary;
  const Audit found = audit(halves_of(400, 1, halves_noise(2)), track);
  EXPECT_NEAR(std::sqrt(found.white_factor), 2, 0.15);
  apply(found, track, summary);
  EXPECT_NEAR(track.points[7].sigma_x, 2 * kSigma, 0.15 * kSigma);
  EXPECT_NEAR(track.points[7].rho_xy, 0.4, 1e-12);  // the whole covariance is multiplied
  EXPECT_TRUE(summary.slow.empty());
  ASSERT_EQ(summary.warnings.size(), 1U);
  EXPECT_NE(summary.warnings[0].find("left and the right half"), std::string::npos);

  Track jumpy = track_of(400, 1, at_rest, noise(1.6));
  apply(audit(halves_of(400, 1, halves_noise(1)), jumpy), jumpy, summary);
  EXPECT_NEAR(jumpy.points[7].sigma_y, 1.6 * kSigma, 0.15 * kSigma);
}

TEST(Audit, ASlowPartIsAddedAndNotMultiplied) {
  Track track = track_of(4000, 1, at_rest, noise(1));
  TrackSummary summary;
  summary.slow = {{"pictures", 0.3 * kSigma, 0.02}};
  const auto wave = [](std::int64_t k, int component, std::mt19937& random) {
    return white(random) + 2 * kSigma * std::sqrt(2.0) * std::sin(0.005 * static_cast<double>(k) + component);
  };
  const Audit found = audit(halves_of(4000, 1, wave), track);
  EXPECT_NEAR(found.white_factor, 1, 0.1);
  EXPECT_NEAR(found.slow_sd, 2 * kSigma, 0.3 * kSigma);
  EXPECT_GT(found.slow_time, 0.05);
  apply(found, track, summary);
  const double total = std::sqrt(found.white_factor * kSigma * kSigma + found.slow_sd * found.slow_sd);
  EXPECT_NEAR(track.points[9].sigma_x, total, 1e-12);
  EXPECT_NEAR(summary.slow_sd(),
              std::sqrt(found.white_factor * std::pow(0.3 * kSigma, 2) + std::pow(found.slow_sd, 2)), 1e-12);
  EXPECT_GT(summary.slow_time(), 0.02);
  EXPECT_LT(summary.slow_time(), found.slow_time);
}

TEST(Audit, WhatCannotBeToldStaysEmpty) {
  Track track = track_of(10, 1, at_rest, noise(1));
  const Audit found = audit({}, track);
  EXPECT_FALSE(found.halves_x || found.halves_y || found.high_frequency);
  TrackSummary summary;
  apply(found, track, summary);
  EXPECT_EQ(track.points[3].sigma_x, kSigma);
}

}  // namespace
}  // namespace tribotrack::vision
