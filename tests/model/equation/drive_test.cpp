#include "model/drive.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tribotrack::model {
namespace {

/// In the platform's frame the part feels minus the platform's acceleration, and gravity's share in the
/// plane.
TEST(Drive, IsMinusThePlatformsAcceleration) {
  Drive d;
  d.amplitude_y = 0.2e-3;
  d.phase_shift = 0.7;
  const double w = d.angular_frequency, h = 1e-3;
  for (const double phase : {0.0, 1.0, 4.0}) {
    const Eigen::Vector2d second =
        (d.displacement(phase + h) - 2 * d.displacement(phase) + d.displacement(phase - h)) / (h * h) * w * w;
    EXPECT_LT((d.acceleration(phase) + second).norm(), 1e-6);
  }
  d.tilt_x = 0.1;
  d.tilt_y = -0.2;
  Drive level = d;
  level.tilt_x = level.tilt_y = 0;
  const Eigen::Vector2d gravity = d.acceleration(1.0) - level.acceleration(1.0);
  EXPECT_NEAR(gravity.x(), 9.81 * std::sin(0.1), 1e-15);
  EXPECT_NEAR(gravity.y(), -9.81 * std::sin(0.2), 1e-15);
}

TEST(Drive, PositivePhaseShiftCirclesClockwise) {
  const Drive d;
  const Eigen::Vector2d now = d.displacement(0.3), next = d.displacement(0.31);
  EXPECT_LT(now.x() * next.y() - now.y() * next.x(), 0);
}

}  // namespace
}  // namespace tribotrack::model
