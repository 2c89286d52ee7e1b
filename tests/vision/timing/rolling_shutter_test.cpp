#include <gtest/gtest.h>

#include "vision/track.h"

namespace tribotrack::vision {
namespace {

/// Part and mark move along straight lines; every frame shows them where they were when their rows were read.
TEST(RollingShutter, PositionsAreThoseOfTheTimesOfTheirRows) {
  constexpr double row_time = 2e-5, middle = 239.5, interval = 4e-3;
  const Point part_speed{300, 150}, mark_speed{-200, 80};
  Track track;
  track.has_marker = true;
  for (int k = 0; k < 6; ++k) {
    TrackPoint p;
    p.time_s = k * interval;
    p.status = TrackStatus::ok;
    // y = y0 + v t with t = frame + row_time (y - middle)
    const auto read_at = [&](double y0, double speed) {
      return (y0 + speed * (p.time_s - row_time * middle)) / (1 - speed * row_time);
    };
    p.y = read_at(400, part_speed.y);
    p.x = 100 + part_speed.x * (p.time_s + row_time * (p.y - middle));
    MarkerPoint mark;
    mark.y = read_at(50, mark_speed.y);
    mark.x = 200 + mark_speed.x * (p.time_s + row_time * (mark.y - middle));
    p.marker = mark;
    track.points.push_back(p);
  }
  shift_to_rows(track, row_time, middle);
  for (const TrackPoint& p : track.points) {
    EXPECT_NEAR(p.x, 100 + part_speed.x * p.time_s, 1e-9);
    EXPECT_NEAR(p.y, 400 + part_speed.y * p.time_s, 1e-9);
    // The mark's speed is taken between frames, whose rows were read a little more than an interval apart.
    EXPECT_NEAR(p.marker->x, 200 + mark_speed.x * p.time_s, 5e-3);
    EXPECT_NEAR(p.marker->y, 50 + mark_speed.y * p.time_s, 5e-3);
  }
}

}  // namespace
}  // namespace tribotrack::vision
