#include "vision/synthesis/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tribotrack::vision {
namespace {

TEST(CounterRandom, GaussianHasTheMomentsAndTailsOfTheNormalDistribution) {
  const CounterRandom random(11, 4);
  const int n = 8000000;
  std::vector<double> beyond(6, 0.0);
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0, neighbours = 0, previous = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.gaussian(i);
    m1 += x;
    m2 += x * x;
    m3 += x * x * x;
    m4 += x * x * x * x;
    neighbours += x * previous;
    previous = x;
    for (int t = 0; t < 6 && std::abs(x) > t; ++t) beyond[t] += 1;
  }
  // Four standard errors; the variances of x, x^2, x^3, x^4 are 1, 2, 15, 96.
  EXPECT_NEAR(m1 / n, 0, 4 / std::sqrt(n));
  EXPECT_NEAR(m2 / n, 1, 4 * std::sqrt(2.0 / n));
  EXPECT_NEAR(m3 / n, 0, 4 * std::sqrt(15.0 / n));
  EXPECT_NEAR(m4 / n, 3, 4 * std::sqrt(96.0 / n));
  EXPECT_NEAR(neighbours / n, 0, 4 / std::sqrt(n));
  for (int t = 1; t < 6; ++t) {
    const double expected = n * std::erfc(t / std::sqrt(2.0));
    EXPECT_NEAR(beyond[t], expected, 4 * std::sqrt(expected) + 1e-3 * expected) << t << " sd";
  }
}

TEST(CounterRandom, StreamsOfSuccessiveFramesAreUncorrelated) {
  const int n = 400000;
  const CounterRandom a(1, 1000), b(1, 1001);
  double product = 0, shifted = 0;
  for (int i = 0; i < n; ++i) {
    product += static_cast<double>(a.gaussian(i)) * b.gaussian(i);
    shifted += static_cast<double>(a.gaussian(i + 1)) * b.gaussian(i);
  }
  EXPECT_NEAR(product / n, 0, 4 / std::sqrt(n));
  EXPECT_NEAR(shifted / n, 0, 4 / std::sqrt(n));
}

}  // namespace
}  // namespace tribotrack::vision
