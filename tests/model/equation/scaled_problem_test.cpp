#include "model/equation/scaled_problem.h"

#include <gtest/gtest.h>

namespace tribotrack::model::internal {
namespace {

TEST(ScaledDrive, SlopeIsTheDerivative) {
  const ScaledDrive<double> drive{{0.1, -0.2}, {0.7, 0.3}, {-0.4, 0.9}};
  constexpr double kStep = 1e-5;
  for (double s = 0; s < 6.3; s += 0.3) {
    const Pair<double> before = drive.at(s - kStep), after = drive.at(s + kStep), slope = drive.slope(s);
    EXPECT_NEAR(slope.x, (after.x - before.x) / (2 * kStep), 1e-9);
    EXPECT_NEAR(slope.y, (after.y - before.y) / (2 * kStep), 1e-9);
  }
}

}  // namespace
}  // namespace tribotrack::model::internal
