// The gate's edges from a lamp: brightness made by numerical integration of a square wave, not by gate_share.
#include "fit/gate_timing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace tribotrack::fit {
namespace {

constexpr double pi = std::numbers::pi;

struct Blinking {
  double w = 62.8, phase_at_zero = 0.4, phi = 1.2, dtau = pi / 3;
  double rate = 500, duration = 2, exposure = 2e-3;
  double on = 225, off = 21, noise = 0.2;
  double jitter = 0;  ///< rad
};

/// Each cycle's edges drawn once; the share of an exposure by counting 2000 slices of it.
LampRecord record(const Blinking& b, std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  const int cycles = static_cast<int>(b.w * b.duration / (2 * pi)) + 4;
  std::vector<double> opening, closing;
  for (int n = -2; n < cycles; ++n) {
    opening.push_back((b.phi + 2 * pi * n + b.jitter * normal(random) - b.phase_at_zero) / b.w);
    closing.push_back((b.phi + b.dtau + 2 * pi * n + b.jitter * normal(random) - b.phase_at_zero) / b.w);
  }
  LampRecord lamp;
  lamp.exposure = b.exposure;
  for (int k = 0; k < static_cast<int>(b.rate * b.duration); ++k) {
    const double t = k / b.rate;
    double lit = 0;
    for (std::size_t n = 0; n < opening.size(); ++n)
      lit +=
          std::max(0.0, std::min(t + b.exposure / 2, closing[n]) - std::max(t - b.exposure / 2, opening[n]));
    lamp.time.push_back(t);
    lamp.level.push_back(b.off + (b.on - b.off) * lit / b.exposure + b.noise * normal(random));
  }
  return lamp;
}

struct Pulls {
  double phi = 0, dtau = 0, worst = 0;
  int trials = 0;
};

Pulls pulls(const Blinking& base, unsigned seed, int trials) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(0, 2 * pi), share(0.15, 0.8);
  Pulls sum;
  for (int k = 0; k < trials; ++k) {
    Blinking b = base;
    b.phi = angle(random);
    b.dtau = share(random) * 2 * pi;
    b.phase_at_zero = angle(random);
    b.w = base.w * (1 + 0.02 * (share(random) - 0.5));
    const auto gate = measure_gate(record(b, random), {b.w, b.phase_at_zero, 0});
    EXPECT_TRUE(gate.timing) << gate.why_not << " in trial " << k;
    if (!gate.timing) continue;
    const double phi = std::remainder(gate.timing->phi.value - b.phi, 2 * pi);
    const double dtau = gate.timing->dtau.value - b.dtau;
    sum.phi += std::pow(phi / gate.timing->phi.sd, 2);
    sum.dtau += std::pow(dtau / gate.timing->dtau.sd, 2);
    sum.worst = std::max({sum.worst, std::abs(phi), std::abs(dtau)});
    ++sum.trials;
  }
  sum.phi = std::sqrt(sum.phi / sum.trials);
  sum.dtau = std::sqrt(sum.dtau / sum.trials);
  return sum;
}

TEST(GateTiming, ExposuresThatFillTheIntervalMeasureTheEdges) {
  const Pulls p = pulls({}, 31, 100);
  EXPECT_LT(p.worst, 3e-3);
  EXPECT_NEAR(p.phi, 1, 0.2);
  EXPECT_NEAR(p.dtau, 1, 0.2);
}

TEST(GateTiming, ShortExposuresBracketTheEdges) {
  Blinking b;
  b.exposure = 50e-6;
  const Pulls p = pulls(b, 32, 100);
  EXPECT_NEAR(p.phi, 1, 0.2);
  EXPECT_NEAR(p.dtau, 1, 0.2);
  EXPECT_LT(p.worst, b.w / b.rate);
}

// Frames that come back to the same phases every cycle leave the gap between two of them: the box is uniform.
TEST(GateTiming, CommensurateSamplingLeavesTheWholeGap) {
  Blinking b;
  b.rate = 100;
  b.w = 2 * pi * 10;  // ten frames a cycle, always the same
  b.exposure = 1e-6;
  b.phase_at_zero = 0.1;
  std::mt19937 random(3);
  for (const double place : {0.05, 0.3, 0.6}) {
    b.phi = 1.2 + place;
    const auto gate = measure_gate(record(b, random), {b.w, b.phase_at_zero, 0});
    ASSERT_TRUE(gate.timing) << gate.why_not;
    EXPECT_NEAR(gate.timing->bracket, 2 * pi / 10, 0.01);
    EXPECT_NEAR(gate.timing->phi.sd, 2 * pi / 10 / std::sqrt(12.0), 0.005);
    EXPECT_LT(std::abs(gate.timing->phi.value - b.phi), 0.5 * gate.timing->bracket);
  }
}

TEST(GateTimingCampaign, DISABLED_AJitterOfTheEdgesIsSeenAndWidensTheSd) {
  const unsigned seed = 33;
  Blinking b;
  b.jitter = 0.02;
  const Pulls p = pulls(b, seed, 60);
  EXPECT_NEAR(p.phi, 1, 0.25);
  EXPECT_NEAR(p.dtau, 1, 0.25);
  std::mt19937 random(seed);
  const auto gate = measure_gate(record(b, random), {b.w, b.phase_at_zero, 0});
  ASSERT_TRUE(gate.timing);
  EXPECT_NEAR(gate.timing->jitter, 0.02, 0.01);
}

TEST(GateTiming, TheClocksSdEntersPhiAlone) {
  std::mt19937 random(4);
  const Blinking b;
  const LampRecord lamp = record(b, random);
  const auto sharp = measure_gate(lamp, {b.w, b.phase_at_zero, 0}).timing;
  const auto vague = measure_gate(lamp, {b.w, b.phase_at_zero, 5e-3}).timing;
  ASSERT_TRUE(sharp && vague);
  EXPECT_NEAR(vague->phi.sd, std::hypot(sharp->phi.sd, 5e-3), 1e-12);
  EXPECT_EQ(vague->dtau.sd, sharp->dtau.sd);
}

TEST(GateTiming, SaturationAndUnknownExposureStillBracket) {
  std::mt19937 random(5);
  const Blinking b;
  LampRecord lamp = record(b, random);
  lamp.clipped = true;
  for (double& level : lamp.level) level = std::min(level * 1.8, 255.0);
  const auto clipped = measure_gate(lamp, {b.w, b.phase_at_zero, 0});
  ASSERT_TRUE(clipped.timing) << clipped.why_not;
  EXPECT_LT(std::abs(clipped.timing->phi.value - b.phi), 3 * clipped.timing->phi.sd);
  EXPECT_LT(std::abs(clipped.timing->dtau.value - b.dtau), 3 * clipped.timing->dtau.sd);
  LampRecord unknown = record(b, random);
  unknown.exposure.reset();
  const auto vague = measure_gate(unknown, {b.w, b.phase_at_zero, 0});
  ASSERT_TRUE(vague.timing) << vague.why_not;
  EXPECT_LT(std::abs(vague.timing->phi.value - b.phi), 3 * vague.timing->phi.sd);
  EXPECT_LT(vague.timing->phi.sd, b.w / b.rate);
}

TEST(GateTiming, AFlashIsNotBelieved) {
  std::mt19937 random(7);
  const Blinking b;
  LampRecord lamp = record(b, random);
  const auto clean = measure_gate(lamp, {b.w, b.phase_at_zero, 0}).timing;
  lamp.level[500] = 150;
  lamp.level[731] = 220;
  const auto flashed = measure_gate(lamp, {b.w, b.phase_at_zero, 0}).timing;
  ASSERT_TRUE(clean && flashed);
  EXPECT_NEAR(flashed->phi.value, clean->phi.value, 5 * clean->phi.sd);
  EXPECT_NEAR(flashed->dtau.value, clean->dtau.value, 5 * clean->dtau.sd);
}

}  // namespace
}  // namespace tribotrack::fit
