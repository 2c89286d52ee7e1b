#include "model/friction.h"

#include <gtest/gtest.h>

#include <numbers>

namespace tribotrack::model {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Friction, ReducedInsideThePulseOnly) {
  const Friction f{0.3, 0.1, 0.5, 1.0, 0.25};
  for (const double turn : {0.0, 2 * kPi, -2 * kPi, 200 * kPi}) {
    EXPECT_EQ(f.coefficient(turn + 0.74), 0.3);
    EXPECT_EQ(f.coefficient(turn + 0.76), 0.1);
    EXPECT_EQ(f.coefficient(turn + 1.74), 0.1);
    EXPECT_EQ(f.coefficient(turn + 1.76), 0.3);
  }
}

TEST(Friction, OnAnEdgeTheValueJustAfter) {
  const Friction f{0.3, 0.1, 0.5, 1.0, 0};
  EXPECT_EQ(f.coefficient(0.5), 0.1);
  EXPECT_EQ(f.coefficient(1.5), 0.3);
}

TEST(Friction, ZeroAndFullWidth) {
  for (const double phase : {0.0, 0.1, 3.0, 6.2}) {
    EXPECT_EQ((Friction{0.3, 0.1, 0.5, 0, 0}.coefficient(phase)), 0.3);
    EXPECT_EQ((Friction{0.3, 0.1, 0.5, 2 * kPi, 0}.coefficient(phase)), 0.1);
  }
}

}  // namespace
}  // namespace tribotrack::model
