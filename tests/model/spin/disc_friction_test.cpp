#include "model/spin/disc_friction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/spinning_disc.h"

namespace tribotrack::model::internal {
namespace {

constexpr double kPi = std::numbers::pi;

test::FaceForce by_formula(double u, double w) {
  const Braking<double> by = braking(u * u, w * w);
  return {by.drag * u, by.brake * w};
}

TEST(DiscFriction, IsTheMeanOverTheFace) {
  for (const auto& [u, w] : {std::pair{1.0, 0.01},
                             {1.0, 0.3},
                             {1.0, 0.33},
                             {1.0, 0.7},
                             {1.0, 0.98},
                             {1.0, 1.0},
                             {0.98, 1.0},
                             {0.7, 1.0},
                             {0.32, 1.0},
                             {0.31, 1.0},
                             {0.01, 1.0}}) {
    SCOPED_TRACE(u / w);
    const test::FaceForce formula = by_formula(u, w), face = test::face_force(u, w);
    EXPECT_NEAR(formula.force, face.force, 1e-12);
    EXPECT_NEAR(formula.torque, face.torque, 1e-12);
  }
}

TEST(DiscFriction, IsTheSumOverDirectionsToo) {
  for (const double ratio : {0.1, 0.5, 0.9, 1.2, 2.0, 5.0}) {
    const test::FaceForce formula = by_formula(1, ratio), sum = test::force_by_directions(1, ratio);
    EXPECT_NEAR(formula.force, sum.force, 1e-10) << ratio;
    EXPECT_NEAR(formula.torque, sum.torque, 1e-9) << ratio;
  }
}

TEST(DiscFriction, LimitsAreThoseOfPurePushAndPureTurn) {
  EXPECT_EQ(by_formula(2, 0).force, 1);
  EXPECT_EQ(by_formula(2, 0).torque, 0);
  EXPECT_EQ(by_formula(0, 3).force, 0);
  EXPECT_DOUBLE_EQ(by_formula(0, 3).torque, 2.0 / 3);
  EXPECT_NEAR(by_formula(1, 1).force, 8 / (3 * kPi), 1e-15);
  EXPECT_NEAR(by_formula(1, 1).torque, 8 / (9 * kPi), 1e-15);
  // To first order: a slow spin feels a viscous torque w/(4 u), a slow push a viscous force u/w.
  EXPECT_NEAR(by_formula(1, 1e-6).torque, 0.25e-6, 1e-18);
  EXPECT_NEAR(by_formula(1e-6, 1).force, 1e-6, 1e-18);
}

TEST(DiscFriction, SeriesAndClosedFormsAgreeWhereTheyMeet) {
  for (const auto function : {face_drag, slow_spin_brake, fast_spin_brake}) {
    const double h = 1e-9;
    const WithSlope below = function(0.1 - h), above = function(0.1 + h);
    EXPECT_NEAR(above.value - below.value, 2 * h * below.slope, 2e-14);
    EXPECT_NEAR(above.slope, below.slope, 1e-8);
  }
}

TEST(DiscFriction, SlopesAreThoseOfTheValues) {
  for (const auto function : {face_drag, slow_spin_brake, fast_spin_brake})
    for (const double m : {0.02, 0.09, 0.2, 0.6, 0.95}) {
      const double h = 1e-5;
      EXPECT_NEAR(function(m).slope, (function(m + h).value - function(m - h).value) / (2 * h), 1e-8) << m;
    }
}

TEST(DiscFriction, DissipatesMostWhatTheFasterMotionCarries) {
  // Force and torque are the gradient of Phi, homogeneous of degree one: Phi = u F + w T, and its mixed
  // slopes agree.
  for (const auto& [u, w] : {std::pair{1.0, 0.5}, {0.5, 1.0}, {1.0, 0.999}}) {
    const double h = 1e-6;
    const double force_by_w = (by_formula(u, w + h).force - by_formula(u, w - h).force) / (2 * h);
    const double torque_by_u = (by_formula(u + h, w).torque - by_formula(u - h, w).torque) / (2 * h);
    EXPECT_NEAR(force_by_w, torque_by_u, 1e-8);
    EXPECT_LT(force_by_w, 0);
  }
}

}  // namespace
}  // namespace tribotrack::model::internal
