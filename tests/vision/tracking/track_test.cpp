#include "vision/track.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "vision/placed_track.h"

namespace tribotrack::vision {
namespace {

TrackPoint at(double x, double y) {
  TrackPoint p;
  p.x = x;
  p.y = y;
  p.sigma_x = 0.03;
  p.sigma_y = 0.01;
  p.rho_xy = 0.5;
  p.status = TrackStatus::ok;
  return p;
}

TEST(Track, MillimetresHaveYUp) {
  Track track;
  track.points = {at(100, 50), at(110, 45)};
  const auto mm = test::in_millimetres(track, 0.1, 0);
  ASSERT_TRUE(mm[0] && mm[1]);
  EXPECT_DOUBLE_EQ(mm[0]->x_mm, 0);
  EXPECT_DOUBLE_EQ(mm[1]->x_mm, 1);
  EXPECT_DOUBLE_EQ(mm[1]->y_mm, 0.5);
  EXPECT_NEAR(mm[1]->sigma_x_mm, 0.003, 1e-15);
  EXPECT_NEAR(mm[1]->sigma_y_mm, 0.001, 1e-15);
  EXPECT_NEAR(mm[1]->rho_xy, -0.5, 1e-12);  // y is turned over
}

TEST(Track, XiAxisBecomesTheXAxis) {
  // A step along the direction xi (counter-clockwise, y up) comes out along +x.
  const double xi = 0.7;
  Track track;
  track.points = {at(0, 0), at(10 * std::cos(xi), -10 * std::sin(xi))};
  const auto mm = test::in_millimetres(track, 0.1, xi);
  EXPECT_NEAR(mm[1]->x_mm, 1, 1e-14);
  EXPECT_NEAR(mm[1]->y_mm, 0, 1e-14);
  // A quarter turn swaps the standard deviations and the sign of the correlation.
  const auto quarter = test::in_millimetres(track, 0.1, std::numbers::pi / 2);
  EXPECT_NEAR(quarter[1]->sigma_x_mm, 0.001, 1e-15);
  EXPECT_NEAR(quarter[1]->sigma_y_mm, 0.003, 1e-15);
  EXPECT_NEAR(quarter[1]->rho_xy, 0.5, 1e-12);
}

TEST(Track, MarkersMotionIsSubtractedAndItsSigmaAdded) {
  Track track;
  track.has_marker = true;
  track.points = {at(100, 50), at(103, 54), at(105, 54), at(0, 0)};
  track.points[0].marker.reset();  // the reference must have a marker
  track.points[1].marker = MarkerPoint{20, 20, 0.04, 1};
  track.points[2].marker = MarkerPoint{21, 18, 0.04, 1};
  track.points[3].status = TrackStatus::lost;
  const auto mm = test::in_millimetres(track, 1, 0);
  EXPECT_FALSE(mm[0]);
  EXPECT_FALSE(mm[3]);
  EXPECT_DOUBLE_EQ(mm[1]->x_mm, 0);
  EXPECT_DOUBLE_EQ(mm[2]->x_mm, 1);
  EXPECT_DOUBLE_EQ(mm[2]->y_mm, -2);
  EXPECT_NEAR(mm[2]->sigma_x_mm, 0.05, 1e-15);
  EXPECT_NEAR(mm[2]->sigma_y_mm, std::hypot(0.01, 0.04), 1e-15);
}

}  // namespace
}  // namespace tribotrack::vision
