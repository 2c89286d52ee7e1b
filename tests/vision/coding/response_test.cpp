#include "vision/coding/response.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "vision/coding/smooth_path.h"

namespace tribotrack::vision {
namespace {

constexpr double kInterval = 1e-3, kW = 2 * std::numbers::pi / 0.04;

std::vector<Point> circle(double amplitude, double delay, double drift, int frames = 300) {
  std::vector<Point> path;
  for (int k = 0; k < frames; ++k) {
    const double phase = kW * (k * kInterval - delay);
    path.push_back(
        {100 + amplitude * std::cos(phase) + drift * k, 80 - amplitude * std::sin(phase) - 0.3 * drift * k});
  }
  return path;
}

/// A drift beside the circle is not what comes back too small, and a constant offset is no error.
TEST(CodedResponse, AttenuationAndDelayOfACircleThatDrifts) {
  for (const double drift : {0.0, 0.2}) {
    SCOPED_TRACE(drift);
    const CodedResponse found =
        coded_response(circle(0.3 * 0.97, 0.4e-3, drift), circle(0.3, 0, drift), kInterval);
    // To first order in w T = 0.063: (1 - a) cos wT, (1 - a) sin wT.
    EXPECT_NEAR(found.attenuation, 1 - 0.97 * std::cos(kW * 0.4e-3), 2e-4);
    EXPECT_NEAR(kW * found.delay, 0.97 * std::sin(kW * 0.4e-3), 1e-3);
  }
}

TEST(CodedResponse, StandardDeviationsHoldTheScatter) {
  double chi2 = 0;
  constexpr int kTrials = 40;
  for (int trial = 0; trial < kTrials; ++trial) {
    SCOPED_TRACE("seed " + std::to_string(trial));
    std::mt19937 random(static_cast<unsigned>(trial));
    std::normal_distribution<> noise(0, 0.02);
    std::vector<Point> seen = circle(0.3, 0, 0);
    for (Point& p : seen) p = {p.x + noise(random), p.y + noise(random)};
    const CodedResponse found = coded_response(seen, circle(0.3, 0, 0), kInterval);
    chi2 += std::pow(found.attenuation / found.attenuation_sd, 2) + std::pow(found.delay / found.delay_sd, 2);
  }
  EXPECT_NEAR(chi2 / (2 * kTrials), 1, 3 * std::sqrt(2.0 / (2 * kTrials)));
}

TEST(SmoothPath, TakesNoiseOutAndLeavesTheMotion) {
  std::mt19937 random(5);
  std::normal_distribution<> noise(0, 0.02);
  const std::vector<Point> path = circle(0.3, 0, 0);
  std::vector<Point> seen = path;
  for (Point& p : seen) p = {p.x + noise(random), p.y + noise(random)};
  const auto rms = [&](const std::vector<Point>& other) {
    double sum = 0;
    for (std::size_t k = 0; k < path.size(); ++k)
      sum += std::pow(path[k].x - other[k].x, 2) + std::pow(path[k].y - other[k].y, 2);
    return std::sqrt(sum / (2.0 * static_cast<double>(path.size())));
  };
  EXPECT_LT(rms(smooth_path(seen, 0.02)), 0.6 * rms(seen));
  EXPECT_EQ(rms(smooth_path(path, 0)), 0) << "nothing is left to smooth";
}

}  // namespace
}  // namespace tribotrack::vision
