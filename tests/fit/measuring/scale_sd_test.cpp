#include <gtest/gtest.h>

#include "fit/measurement.h"

namespace tribotrack::fit {
namespace {

// A scale that is off stretches a displacement: its length is in doubt, its direction is not.
TEST(ScaleSd, StretchesLengthsAndLeavesAnglesAlone) {
  Displacement d;
  d.vector = {3e-3, 4e-3};
  d.covariance = 1e-12 * Eigen::Matrix2d::Identity();
  d.duration = 2;
  derive_alpha_and_v(d);
  const Displacement scaled = with_scale_sd(d, 0.01);
  const Eigen::Vector2d along(0.6, 0.8), across(-0.8, 0.6);
  EXPECT_NEAR(along.dot(scaled.covariance * along), 1e-12 + 5e-5 * 5e-5, 1e-20);
  EXPECT_NEAR(across.dot(scaled.covariance * across), 1e-12, 1e-20);
  EXPECT_NEAR(scaled.alpha->sd, d.alpha->sd, 1e-12);
  EXPECT_NEAR(scaled.mean_velocity.sd, std::sqrt(1e-12 + 2.5e-9) / 2, 1e-12);
  EXPECT_EQ(scaled.vector, d.vector);

  PlatformMotion motion;
  motion.amplitude = {3e-4, 4e-6};
  motion.phase_at_zero = {1, 0.1};
  EXPECT_NEAR(with_scale_sd(motion, 0.01).amplitude.sd, 5e-6, 1e-15);
  EXPECT_EQ(with_scale_sd(motion, 0.01).phase_at_zero.sd, 0.1);
}

}  // namespace
}  // namespace tribotrack::fit
