#include "vision/layers/learning/anderson_acceleration.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tribotrack::vision {
namespace {

TEST(AndersonAcceleration, SolvesALinearIterationOfFewModesExactly) {
  // x = b + M x with rates 0.97, 0.9 and -0.5: plain iteration would need 700 steps for 1e-9.
  const Eigen::Vector3d rate(0.97, 0.9, -0.5), b(1, -2, 3);
  const Eigen::Vector3d exact = b.array() / (1 - rate.array());
  AndersonAcceleration acceleration;
  Eigen::VectorXd x = Eigen::Vector3d::Zero();
  for (int k = 0; k < 5; ++k) x = acceleration.next(x, b + Eigen::VectorXd(rate.cwiseProduct(x)));
  EXPECT_LT((x - exact).norm(), 1e-9 * exact.norm());
}

TEST(AndersonAcceleration, FirstStepIsThePlainOne) {
  AndersonAcceleration acceleration;
  const Eigen::VectorXd to = Eigen::Vector2d(3, 4);
  EXPECT_EQ(acceleration.next(Eigen::Vector2d(1, 1), to), to);
}

TEST(AndersonAcceleration, FindsTheFixedPointOfCosine) {
  AndersonAcceleration acceleration(1);  // the secant method
  Eigen::VectorXd x = Eigen::VectorXd::Constant(1, 0.5);
  for (int k = 0; k < 7; ++k) x = acceleration.next(x, x.array().cos());
  EXPECT_NEAR(x(0), 0.7390851332151607, 1e-10);
}

}  // namespace
}  // namespace tribotrack::vision
