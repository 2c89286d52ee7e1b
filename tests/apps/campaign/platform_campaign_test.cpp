// Platform and gate from rendered recordings: the figures promised, and that the standard deviations are the
// scatter. Noise 2 grey levels, 2 s at 500 frames/s, disc radius 30 px, a marker of 14 px.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <string>

#include "apps/rendered_platform.h"

namespace tribotrack::test {
namespace {

constexpr double pi = std::numbers::pi;

/// Errors of one quantity over many recordings.
struct Errors {
  double squares = 0, standardised = 0, worst = 0;
  int count = 0;
  void add(double error, double sd) {
    squares += error * error;
    standardised += error * error / (sd * sd);
    worst = std::max(worst, std::abs(error));
    ++count;
  }
  double rms() const { return std::sqrt(squares / count); }
  double pull() const { return std::sqrt(standardised / count); }
};

std::map<std::string, Errors> errors_over(int recordings, double exposure, unsigned seed,
                                          bool marker = true) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(0, 2 * pi), width(pi / 6, pi), share(-0.5, 0.5);
  std::map<std::string, Errors> errors;
  for (int k = 0; k < recordings; ++k) {
    RenderedPlatform truth;
    truth.seed = seed + 1000u * static_cast<unsigned>(k);
    truth.exposure = exposure;
    truth.phi = angle(random);
    truth.dtau = width(random);
    truth.phase_at_zero = angle(random);
    truth.w *= 1 + 0.04 * share(random);
    truth.radius_px *= 1 + 0.2 * share(random);
    truth.marker = marker;
    const MeasuredPlatform seen = measure(truth);
    EXPECT_TRUE(seen.platform) << "recording " << k;
    EXPECT_TRUE(seen.gate.timing) << "recording " << k << ": " << seen.gate.why_not;
    if (!seen.platform || !seen.gate.timing) continue;
    const fit::PlatformMotion& m = *seen.platform;
    const auto off = [](double a, double b) { return std::remainder(a - b, 2 * pi); };
    errors["A"].add(m.amplitude.value / truth.radius_px - 1, m.amplitude.sd / truth.radius_px);
    errors["A_y"].add(m.amplitude_y.value / truth.radius_px - 1, m.amplitude_y.sd / truth.radius_px);
    errors["w"].add(m.angular_frequency.value / truth.w - 1, m.angular_frequency.sd / truth.w);
    errors["phase"].add(off(m.phase_at_zero.value, truth.phase_at_zero), m.phase_at_zero.sd);
    errors["epsilon"].add(off(m.phase_shift.value, truth.epsilon), m.phase_shift.sd);
    errors["phi"].add(off(seen.gate.timing->phi.value, truth.phi), seen.gate.timing->phi.sd);
    errors["dtau"].add(seen.gate.timing->dtau.value - truth.dtau, seen.gate.timing->dtau.sd);
  }
  for (const auto& [name, e] : errors)
    std::printf("%-8s rms %.3g, worst %.3g, standardised %.3f over %d recordings\n", name.c_str(), e.rms(),
                e.worst, e.pull(), e.count);
  return errors;
}

/// The figures, as rms over the recordings.
void expect_figures(std::map<std::string, Errors>& errors) {
  EXPECT_LT(errors["A"].rms(), 2e-4);
  EXPECT_LT(errors["A_y"].rms(), 2e-4);
  EXPECT_LT(errors["w"].rms(), 1e-5);
  EXPECT_LT(errors["phase"].rms(), 0.2e-3);
}

TEST(PlatformRendered, ExposureFillsTheInterval) {
  const unsigned seed = 20261;
  SCOPED_TRACE(seed);
  auto errors = errors_over(5, 2e-3, seed);
  expect_figures(errors);
  EXPECT_LT(errors["phi"].worst, 3e-3);
  EXPECT_LT(errors["dtau"].worst, 3e-3);
  // Seven quantities, five recordings: the mean square of 35 pulls, between the 0.5 % and 99.5 % points of
  // chi^2 / 35.
  double squares = 0;
  for (const auto& [name, e] : errors) squares += e.standardised / 35;
  EXPECT_GT(squares, 0.49);
  EXPECT_LT(squares, 1.72);
}

TEST(PlatformCampaign, DISABLED_HundredRecordingsExposureFillsTheInterval) {
  const unsigned seed = 20262;
  SCOPED_TRACE(seed);
  auto errors = errors_over(100, 2e-3, seed);
  expect_figures(errors);
  EXPECT_LT(errors["phi"].worst, 3e-3);
  EXPECT_LT(errors["dtau"].worst, 3e-3);
  for (const auto& [name, e] : errors) {
    EXPECT_GT(e.pull(), 0.8) << name;
    EXPECT_LT(e.pull(), 1.2) << name;
  }
}

TEST(PlatformCampaign, DISABLED_HundredRecordingsShortExposure) {
  const unsigned seed = 20263;
  SCOPED_TRACE(seed);
  auto errors = errors_over(100, 0.1e-3, seed);
  expect_figures(errors);
  for (const auto& [name, e] : errors) {
    EXPECT_GT(e.pull(), 0.8) << name;
    EXPECT_LT(e.pull(), 1.2) << name;
  }
}

}  // namespace
}  // namespace tribotrack::test
