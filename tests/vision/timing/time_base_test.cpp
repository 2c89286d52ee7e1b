#include "vision/time_base.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/picture.h"
#include "vision/track.h"

namespace tribotrack::vision {
namespace {

TEST(TimeBase, TheMostTrustedAcceptedCandidateWinsAndTheOthersSayWhyNot) {
  const TimeBase base = choose_time_base({{"sidecar", 0, false, "no rate in it"},
                                          {"tag", 240, true, "written by the camera"},
                                          {"container time stamps", 120, true, "uniform"}});
  ASSERT_TRUE(base.known());
  EXPECT_EQ(*base.rate_hz, 240);
  EXPECT_EQ(base.source, "tag");
  ASSERT_EQ(base.candidates.size(), 3u);
  EXPECT_FALSE(base.candidates[0].accepted);
  EXPECT_TRUE(base.candidates[1].accepted);
  EXPECT_FALSE(base.candidates[2].accepted);
  EXPECT_EQ(base.candidates[2].reason, "tag is trusted more");
  EXPECT_EQ(base.why_unknown(), "");
  EXPECT_DOUBLE_EQ(base.time_s(12), 0.05);
}

TEST(TimeBase, UsualPlaybackRates) {
  for (const double rate :
       {24.0, 23.976, 25.0, 29.97, 30000.0 / 1001, 30.0, 50.0, 60000.0 / 1001, 60.0, 600.0, 1000.0, 65535.0})
    EXPECT_TRUE(usual_playback_rate(rate)) << rate;
  for (const double rate : {15.0, 24.5, 31.0, 48.0, 100.0, 120.0, 239.76, 240.0, 250.0, 500.0, 601.5, 998.0,
                            1002.0, 7000.0, 65000.0})
    EXPECT_FALSE(usual_playback_rate(rate)) << rate;
  EXPECT_EQ(usual_playback_rate(30000.0 / 1001), 29.97);
}

TEST(TimeBase, APlaybackRateIsNoEvidenceWithoutAReason) {
  const TimeBaseCandidate played{"container time stamps", 30000.0 / 1001, false, "a playback rate"};
  EXPECT_THROW(require_reason(29.97, "", played), InputError);
  EXPECT_NO_THROW(require_reason(29.97, "set on the camera", played));
  EXPECT_NO_THROW(require_reason(240, "", played));
  EXPECT_NO_THROW(require_reason(30, "", {"container time stamps", 240, true, "uniform"}));
  EXPECT_NO_THROW(require_reason(1000, "", {"container time stamps", 1000, false, "a container's ticks"}));
}

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
