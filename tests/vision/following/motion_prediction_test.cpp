#include "vision/following/prediction.h"

#include <gtest/gtest.h>

namespace tribotrack::vision {
namespace {

TEST(MotionPrediction, ConstantVelocityIsPredictedExactlyAlsoAcrossGaps) {
  MotionPrediction motion;
  for (const std::int64_t frame : {3, 4, 6, 9})
    motion.add(frame, {10 + 2.5 * static_cast<double>(frame), 7.0});
  const Point p = motion.at(15);
  EXPECT_DOUBLE_EQ(p.x, 10 + 2.5 * 15);
  EXPECT_DOUBLE_EQ(p.y, 7);
  EXPECT_DOUBLE_EQ(motion.top_speed(), 2.5);
  EXPECT_DOUBLE_EQ(motion.speed(), 2.5);
}

TEST(MotionPrediction, ReachShrinksWithSuccessAndGrowsWithSurpriseAndGap) {
  MotionPrediction motion;
  motion.add(0, {0, 0});
  const double ignorant = motion.reach(1);
  for (int k = 1; k < 40; ++k) motion.add(k, {static_cast<double>(k), 0});
  const double steady = motion.reach(40);
  EXPECT_LT(steady, ignorant);
  EXPECT_GT(motion.reach(45), steady);
  motion.add(40, {60, 0});
  EXPECT_GT(motion.reach(41), 2 * steady);
}

TEST(MotionPrediction, TheSameFrameSeenBetterReplacesIt) {
  MotionPrediction motion;
  motion.add(5, {1, 1});
  motion.add(5, {2, 2});
  EXPECT_DOUBLE_EQ(motion.at(6).x, 2);
  motion.add(6, {4, 2});
  EXPECT_DOUBLE_EQ(motion.at(7).x, 6);
}

}  // namespace
}  // namespace tribotrack::vision
