#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "fit/measurement.h"

namespace tribotrack::fit {
namespace {

/// The fundamental of what a play shows of cos, by following it step by step.
std::complex<double> followed(double half_width) {
  constexpr int kSteps = 200000;
  const auto step = [&](double shown, double x) { return std::clamp(shown, x - half_width, x + half_width); };
  double shown = 1 - half_width;
  std::complex<double> sum = 0;
  for (int turn = 0; turn < 2; ++turn)
    for (int k = 0; k < kSteps; ++k) {
      const double phase = 2 * std::numbers::pi * k / kSteps;
      shown = step(shown, std::cos(phase));
      if (turn == 1) sum += 2.0 / kSteps * shown * std::polar(1.0, -phase);
    }
  return sum;
}

TEST(Play, DescribingFunctionIsThatOfThePlayFollowed) {
  for (const double r : {0.01, 0.1, 0.3, 0.6, 0.95}) {
    SCOPED_TRACE(r);
    const std::complex<double> fundamental = followed(r);
    const SeenThroughPlay seen = seen_through_play(0.28e-3, r * 0.28e-3);
    EXPECT_NEAR(1 - seen.attenuation, std::abs(fundamental), 1e-4);
    EXPECT_NEAR(seen.delay, -std::arg(fundamental), 1e-4);
  }
}

TEST(Play, LimitsAreExact) {
  EXPECT_EQ(seen_through_play(1, 0).delay, 0);
  EXPECT_EQ(seen_through_play(1, 0).attenuation, 0);
  EXPECT_EQ(seen_through_play(1, 1).attenuation, 1);
  EXPECT_NEAR(seen_through_play(1, 1e-6).delay, 4e-6 / std::numbers::pi, 1e-9);
}

}  // namespace
}  // namespace tribotrack::fit
