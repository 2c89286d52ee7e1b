#include "model/equation/phase.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/quad_math.h"

namespace tribotrack::model::internal {
namespace {

using reference::quad;

/// The same in quadruple precision.
double rest_of(quad phase) {
  const quad turn = 2 * reference::pi();
  return static_cast<double>(phase - turn * reference::floor_of(phase / turn));
}

/// Distance on the circle.
double off(double a, double b) {
  return std::abs(std::remainder(a - b, kTwoPi));
}

TEST(Phase, NothingIsLostHoweverManyCyclesItCounts) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(0, 9);
  for (int k = 0; k < 1000; ++k) {
    const double phase = std::pow(10, exponent(random));
    const Phase reduced = reduce(phase);
    EXPECT_GE(reduced.rest, 0);
    EXPECT_LT(reduced.rest, kTwoPi);
    EXPECT_LT(off(reduced.rest, rest_of(phase)), 2e-15) << phase;
    EXPECT_EQ(reduced.cycles, static_cast<double>(reference::floor_of(quad(phase) / (2 * reference::pi()))));
  }
}

// w t as a double is off by up to half a unit in its last place: 1e-9 rad after 1e7 rad.
TEST(Phase, AProductKeepsWhatItsRoundingLost) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> frequency(60, 70), time(1e4, 1e7);
  double largest = 0;
  for (int k = 0; k < 1000; ++k) {
    const double w = frequency(random), t = time(random);
    const double exact = rest_of(quad(w) * quad(t));
    EXPECT_LT(off(reduce_product(w, t).rest, exact), 2e-15);
    largest = std::max(largest, off(reduce(w * t).rest, exact));
  }
  EXPECT_GT(largest, 1e-9) << "the rounding of the product does not matter here: this test shows nothing";
}

}  // namespace
}  // namespace tribotrack::model::internal
