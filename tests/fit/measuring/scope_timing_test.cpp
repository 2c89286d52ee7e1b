// Traces made from the definition: pulses at wt = 2 pi n, a 5890 Hz carrier gated by wt in (phi, phi + dtau).
#include "fit/scope_timing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace tribotrack::fit {
namespace {

constexpr double pi = std::numbers::pi;

struct TraceTruth {
  double w = 62.8, phase_at_zero = 0.7, phi = 2.1, dtau = pi / 3;
  double start = -1.03, increment = 1e-5, duration = 2.1;
  double noise = 0.02, delay = 0;
};

ScopeTrace trace_of(const TraceTruth& truth, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto turned = [](double angle) { return angle - 2 * pi * std::floor(angle / (2 * pi)); };
  ScopeTrace trace;
  trace.start = truth.start;
  trace.increment = truth.increment;
  for (int n = 0; n < static_cast<int>(truth.duration / truth.increment); ++n) {
    const double t = truth.start + n * truth.increment;
    const double since = turned(truth.w * (t - truth.delay) + truth.phase_at_zero) / truth.w;
    // A pulse with a ramp of 20 us about the sensor's moment.
    double v = std::clamp(0.5 + since / 20e-6, 0.0, 1.0);
    if (since > 1e-3) v = 0;
    if (const double before = 2 * pi / truth.w - since; before < 10e-6) v = 0.5 - before / 20e-6;
    trace.sensor.push_back(3.3 * v + truth.noise * normal(random));
    const bool open = turned(truth.w * t + truth.phase_at_zero - truth.phi) < truth.dtau;
    trace.actuator.push_back((open ? 5 * std::sin(2 * pi * 5890 * t) : 0) + 0.4 +
                             truth.noise * normal(random));
  }
  return trace;
}

TEST(ScopeTiming, PulsesAndBurstsComeBack) {
  for (const double phi : {0.0, 2.1, 6.2})
    for (const double dtau : {0.3, pi / 3, 5.0}) {
      TraceTruth truth;
      truth.phi = phi;
      truth.dtau = dtau;
      const ScopeEvents events = find_scope_events(trace_of(truth, 1), {});
      const auto sensor = sensor_clock(events, {});
      ASSERT_TRUE(sensor);
      EXPECT_NEAR(sensor->angular_frequency.value, truth.w, 1e-5 * truth.w);
      EXPECT_NEAR(std::remainder(sensor->clock.phase_at_zero - truth.phase_at_zero, 2 * pi), 0, 3e-4);
      const auto gate = gate_from_scope(events, sensor->clock);
      ASSERT_TRUE(gate.timing) << gate.why_not;
      // A quarter of a carrier period is 42 us or 2.7 mrad: what a burst's first swing leaves open.
      EXPECT_NEAR(std::remainder(gate.timing->phi.value - phi, 2 * pi), 0, 1.5e-3) << phi << " " << dtau;
      EXPECT_NEAR(gate.timing->dtau.value, dtau, 1.5e-3) << phi << " " << dtau;
      EXPECT_LT(std::abs(gate.timing->dtau.value - dtau), 4 * gate.timing->dtau.sd) << phi << " " << dtau;
    }
}

// What blurs both edges of a burst alike leaves its middle where it is; half a sample is 1.3 mrad here.
TEST(ScopeTiming, TheMiddleOfABurstIsNotHalfASampleLate) {
  double late = 0;
  int count = 0;
  for (const double phi : {0.3, 1.9, 3.1, 4.4}) {
    TraceTruth truth;
    truth.phi = phi;
    truth.increment = 4.03e-5;
    const ScopeEvents events = find_scope_events(trace_of(truth, 4), {});
    const auto gate = gate_from_scope(events, {truth.w, truth.phase_at_zero, 0});
    ASSERT_TRUE(gate.timing) << gate.why_not;
    late += std::remainder(gate.timing->phi.value + 0.5 * gate.timing->dtau.value - phi - 0.5 * truth.dtau,
                           2 * pi);
    ++count;
  }
  EXPECT_NEAR(late / count, 0, 0.5e-3);
}

TEST(ScopeTiming, TheSensorsDelayIsTakenOff) {
  TraceTruth truth;
  truth.delay = 0.5e-3;
  ScopeOptions options;
  options.sensor_delay = 0.5e-3;
  options.sensor_delay_sd = 0.1e-3;
  const ScopeEvents events = find_scope_events(trace_of(truth, 2), options);
  const auto sensor = sensor_clock(events, options);
  ASSERT_TRUE(sensor);
  EXPECT_NEAR(std::remainder(sensor->clock.phase_at_zero - truth.phase_at_zero, 2 * pi), 0, 3e-4);
  EXPECT_NEAR(sensor->clock.phase_sd, truth.w * 0.1e-3, 1e-4);
}

TEST(ScopeTiming, AMissedPulseCostsNoPhase) {
  ScopeEvents events = find_scope_events(trace_of({}, 3), {});
  const auto whole = sensor_clock(events, {});
  events.pulses.erase(events.pulses.begin() + 7);
  const auto missed = sensor_clock(events, {});
  ASSERT_TRUE(whole && missed);
  EXPECT_NEAR(missed->angular_frequency.value, whole->angular_frequency.value,
              4 * whole->angular_frequency.sd);
}

std::string complaint(const ScopeTrace& trace, const ScopeOptions& options = {}) {
  try {
    find_scope_events(trace, options);
  } catch (const DataError& error) {
    return error.what();
  }
  return "none";
}

TEST(ScopeTiming, SwappedChannelsAndAnotherCarrierAreRecognised) {
  for (const double noise : {0.0, 0.02, 0.5}) {
    TraceTruth truth;
    truth.noise = noise;
    const ScopeTrace trace = trace_of(truth, 5);
    EXPECT_EQ(complaint(trace), "none") << noise;
    ScopeTrace swapped = trace;
    std::swap(swapped.sensor, swapped.actuator);
    EXPECT_NE(complaint(swapped).find("swapped"), std::string::npos) << noise;
    EXPECT_NE(complaint(trace, {.carrier_hz = 300}).find("carrier_hz = 300"), std::string::npos) << noise;
    EXPECT_EQ(complaint(trace, {.carrier_hz = 5900}), "none") << noise;
  }
}

TEST(ScopeTiming, BurstsThatDoNotFollowThePlatformGiveNoTiming) {
  const ScopeEvents events = find_scope_events(trace_of({}, 6), {});
  PhaseClock other = sensor_clock(events, {})->clock;
  other.angular_frequency *= 1.1;
  const GateMeasurement gate = gate_from_scope(events, other);
  EXPECT_FALSE(gate.timing);
  EXPECT_NE(gate.why_not.find("from turn to turn"), std::string::npos) << gate.why_not;
}

}  // namespace
}  // namespace tribotrack::fit
