#include "vision/timing/clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "vision/time_base.h"

namespace tribotrack::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using Ticks = std::vector<std::int64_t>;

/// The first `frames` slots at `rate` in whole ticks, without those of `dropped`.
Ticks rounded_stamps(double rate, double tick_s, int frames, const std::vector<int>& dropped = {}) {
  Ticks ticks;
  for (int k = 0; k < frames; ++k)
    if (std::ranges::find(dropped, k) == dropped.end()) ticks.push_back(std::llround(k / rate / tick_s));
  return ticks;
}

ClockEvidence stamps_of(Ticks ticks, double tick_s, double stated_rate_hz = 0) {
  ClockEvidence evidence;
  evidence.ticks = std::move(ticks);
  evidence.tick_s = tick_s;
  evidence.stated_rate_hz = stated_rate_hz;
  return evidence;
}

TimeBaseCandidate judge(Ticks ticks, double tick_s, double stated_rate_hz) {
  return judge_stamps(stamps_of(std::move(ticks), tick_s, stated_rate_hz)).candidate;
}

struct Judged {
  TimeBase base;
  std::vector<std::string> notes;
};

Judged time_by(const ClockEvidence& evidence, std::optional<double> fps = {}) {
  Judged judged;
  judged.base = judge_time(evidence, {.frame_rate_hz = fps}, 0, judged.notes);
  return judged;
}

TEST(Clock, PlaybackRatesAreNot) {
  for (const double rate : {25.0, 30000.0 / 1001, 60.0, 600.0, 1000.0, 65535.0}) {
    const auto judged = judge(rounded_stamps(rate, 1 / rate, 200), 1 / rate, rate);
    EXPECT_FALSE(judged.accepted) << rate;
    EXPECT_THAT(judged.reason, HasSubstr("playback rate"));
  }
}

TEST(Clock, CoarseTicksNeedTheContainersOwnRate) {
  const auto ticks = rounded_stamps(7000, 1e-3, 200);  // 28 ms in ticks of 1 ms
  EXPECT_FALSE(judge(ticks, 1e-3, 0).accepted);
  const auto judged = judge(ticks, 1e-3, 7000);
  EXPECT_TRUE(judged.accepted) << judged.reason;
  EXPECT_EQ(judged.rate_hz, 7000);
  EXPECT_FALSE(judge(ticks, 1e-3, 9000).accepted) << "a stated rate that the stamps contradict";
}

/// Every standard clock: two ticks to a frame are enough where steps are rounded, one where it is a slot.
TEST(Clock, FramesMissingAreCountedInTicksOfAnyClock) {
  struct Case {
    double rate, tick_s;
  };
  for (const Case& one :
       {Case{240, 1.0 / 2400}, Case{240, 1.0 / 600}, Case{240, 1.0 / 480}, Case{240, 1.0 / 240},
        Case{240, 1e-3}, Case{239.76, 1e-3}, Case{480, 1e-3}, Case{120, 1.0 / 600}, Case{960, 1.0 / 90000},
        Case{240, 1.0 / 15360}, Case{500, 1e-6}, Case{12345, 1e-7}}) {
    SCOPED_TRACE(std::to_string(one.rate) + " Hz in ticks of " + std::to_string(one.tick_s));
    for (const int gap : {1, 2, 7}) {
      std::vector<int> dropped;
      for (int k = 0; k < gap; ++k) dropped.push_back(500 + k);
      dropped.push_back(1700);
      const auto evidence = stamps_of(rounded_stamps(one.rate, one.tick_s, 6000, dropped), one.tick_s);
      const Judged judged = time_by(evidence);
      ASSERT_TRUE(judged.base.known()) << judged.base.why_unknown();
      EXPECT_NEAR(*judged.base.rate_hz / one.rate, 1, one.tick_s * one.rate / 6000) << "a tick over the span";
      ASSERT_EQ(judged.base.check.missing.size(), 2u);
      EXPECT_EQ(judged.base.check.missing[0].after, 499);
      EXPECT_EQ(judged.base.check.missing[0].count, gap);
      EXPECT_EQ(judged.base.check.missing[1].after, 1699 - gap);
      EXPECT_NEAR(judged.base.time_s(1700 - gap), 1701 / one.rate, 0.1 * one.tick_s);
      // The user's rate sets the unit and leaves the gaps.
      const Judged given = time_by(evidence, 100);
      EXPECT_DOUBLE_EQ(given.base.time_s(499), 4.99);
      EXPECT_DOUBLE_EQ(given.base.time_s(500), 5 + 0.01 * gap);
      EXPECT_THAT(given.notes, ::testing::Contains(HasSubstr("gaps and changes stay")));
    }
  }
}

TEST(Clock, ASlotWithoutAPictureIsAGap) {
  ClockEvidence evidence = stamps_of({3, 4, 5, 8, 9}, 1.0 / 300, 300);
  evidence.slots = true;
  const TimeBase base = time_by(evidence).base;
  EXPECT_EQ(base.rate_hz, 300);
  EXPECT_DOUBLE_EQ(base.time_s(3), 5 / 300.0);
  EXPECT_EQ(base.check.missing_frames(), 2);
  // Stamps in milliseconds that were copied into such a container are still stamps.
  evidence = stamps_of(rounded_stamps(239.4, 1e-3, 4000), 1e-3, 1000);
  evidence.slots = true;
  EXPECT_NEAR(*time_by(evidence).base.rate_hz, 239.4, 1e-3);
  EXPECT_EQ(time_by(evidence).base.check.missing_frames(), 0);
}

TEST(Clock, ARateGivenDoesNotHideThatStampsTellNothing) {
  Ticks ticks{0};
  for (int k = 0; k < 300; ++k) ticks.push_back(ticks.back() + 1 + k / 9 % 3);
  EXPECT_THAT(time_by(stamps_of(ticks, 1e-3), 500).notes, ElementsAre(HasSubstr("times count frames")));
  ticks.back() = std::numeric_limits<std::int64_t>::max();
  ticks.front() = std::numeric_limits<std::int64_t>::min();
  EXPECT_FALSE(time_by(stamps_of(ticks, 1e-3)).base.known());
}

TEST(Clock, AVariableRateIsTakenStampByStamp) {
  Ticks ticks{0};
  for (int k = 0; k < 300; ++k) ticks.push_back(ticks.back() + 4000 + 37 * (k * k % 29));
  ClockEvidence evidence = stamps_of(ticks, 1e-6);
  const TimeBase base = time_by(evidence).base;
  ASSERT_TRUE(base.known()) << base.why_unknown();
  EXPECT_TRUE(base.check.variable);
  EXPECT_NEAR(*base.rate_hz, 300 / (1e-6 * static_cast<double>(ticks.back())), 0.2) << "a count over a span";
  for (std::size_t k = 0; k < ticks.size(); ++k)
    EXPECT_NEAR(base.stamps_s.at(k), 1e-6 * static_cast<double>(ticks[k]), 1e-12);
  // A rate of ten times that, by tag or user: slowed for playback, the spacing stays.
  for (const bool users : {false, true}) {
    if (!users) evidence.camera = {{"tag", 10 * *base.rate_hz, true, "written by the camera"}};
    const TimeBase scaled = time_by(evidence, users ? std::optional(10 * *base.rate_hz) : std::nullopt).base;
    EXPECT_NEAR(scaled.stamps_s.back(), base.stamps_s.back() / 10, 1e-12);
  }
}

TEST(Clock, UnevenOnesProveNothingOnCoarseTicksOrNearAPlaybackRate) {
  Ticks ticks{0};
  for (int k = 0; k < 300; ++k) ticks.push_back(ticks.back() + 3 + k % 3);
  EXPECT_THAT(judge(ticks, 1e-3, 0).reason, HasSubstr("too coarse"));
  ticks = {0};
  for (int k = 0; k < 300; ++k) ticks.push_back(ticks.back() + 2 + 3 * (k / 9 % 3));
  EXPECT_THAT(judge(ticks, 1e-3, 0).reason, HasSubstr("too coarse to time frames"));
  ticks = {0};
  for (int k = 0; k < 300; ++k) ticks.push_back(ticks.back() + 33000 + 37 * (k * k % 29));
  EXPECT_FALSE(judge(ticks, 1e-6, 0).accepted);
  EXPECT_THAT(judge(ticks, 1e-6, 0).reason, HasSubstr("playback rate"));
  ticks[7] = ticks[6];
  EXPECT_THAT(judge(ticks, 1e-6, 0).reason, HasSubstr("do not rise"));
}

/// Stamps in microseconds from counts of steps and their lengths in s.
StampCheck check(const std::vector<std::pair<int, double>>& steps) {
  double time = 0;
  Ticks ticks{0};
  for (const auto& [count, step] : steps)
    for (int k = 0; k < count; ++k) ticks.push_back(std::llround((time += step) * 1e6));
  return judge_stamps(stamps_of(std::move(ticks), 1e-6)).check;
}

TEST(StampCheck, MissingFramesAreNamed) {
  const StampCheck found = check({{40, 0.002}, {1, 0.004}, {30, 0.002}, {1, 0.010}, {9, 0.002}});
  EXPECT_FALSE(found.uniform);
  EXPECT_FALSE(found.variable);
  EXPECT_EQ(found.missing_frames(), 5);
  EXPECT_THAT(findings(found, -5), ElementsAre(HasSubstr("1 frame is missing between image 35 and 36"),
                                               HasSubstr("4 frames are missing between image 66 and 67")));
}

TEST(StampCheck, AClockThatBeginsAnewAfterAGapKeepsItsStamps) {
  ClockEvidence evidence = stamps_of({}, 1e-6);
  for (int k = 0; k < 50; ++k) evidence.ticks.push_back(2000 * k);
  for (int k = 0; k < 50; ++k) evidence.ticks.push_back(2000 * (50 + k) + 4700);
  const TimeBase base = time_by(evidence).base;
  EXPECT_NEAR(base.time_s(50) - base.time_s(49), 6.7e-3, 1e-9);
  EXPECT_EQ(base.check.missing_frames(), 2);
}

TEST(StampCheck, AChangeOfRateIsNoGap) {
  const StampCheck found = check({{50, 0.002}, {60, 0.0005}, {20, 0.004}});
  ASSERT_EQ(found.stretches.size(), 3u);
  EXPECT_NEAR(found.stretches[1].rate_hz, 2000, 1e-6);
  EXPECT_EQ(found.stretches[1].first, 50);
  EXPECT_EQ(found.stretches[1].last, 110);
  EXPECT_THAT(found.missing, IsEmpty());
  EXPECT_THAT(findings(found, 0),
              ElementsAre(HasSubstr("500 Hz from image 0 to 50, 2000 Hz from image 50 to 110, "
                                    "250 Hz from image 110 to 130")));
}

TEST(StampCheck, AnImageFromAnotherDayIsAStray) {
  const StampCheck found = check({{233, 0.01}, {1, 2.5e7}});
  EXPECT_THAT(found.strays, ElementsAre(234));
  EXPECT_THAT(findings(found, 0), ElementsAre(HasSubstr("image 234")));
}

}  // namespace
}  // namespace tribotrack::vision
