#include "vision/timing/container_timestamps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "vision/time_base.h"

namespace tribotrack::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::int64_t> rounded_stamps(double rate, double tick_s, int frames) {
  std::vector<std::int64_t> ticks;
  for (int k = 0; k < frames; ++k) ticks.push_back(std::llround(k / rate / tick_s));
  return ticks;
}

TimeBaseCandidate judge(std::span<const std::int64_t> ticks, double tick_s, double stated_rate_hz) {
  return judge_container_timestamps(ticks, tick_s, stated_rate_hz).candidate;
}

TEST(ContainerTimestamps, UniformTicksOfTheRateItselfAreBelieved) {
  const auto judged = judge(rounded_stamps(7000, 1.0 / 7000, 200), 1.0 / 7000, 0);
  EXPECT_TRUE(judged.accepted) << judged.reason;
  EXPECT_DOUBLE_EQ(judged.rate_hz, 7000);
}

TEST(ContainerTimestamps, PlaybackRatesAreNot) {
  for (const double rate : {25.0, 30000.0 / 1001, 60.0, 600.0, 1000.0, 65535.0}) {
    const auto judged = judge(rounded_stamps(rate, 1 / rate, 200), 1 / rate, rate);
    EXPECT_FALSE(judged.accepted) << rate;
    EXPECT_THAT(judged.reason, HasSubstr("playback rate"));
  }
}

TEST(ContainerTimestamps, CoarseTicksNeedTheContainersOwnRate) {
  const auto ticks = rounded_stamps(7000, 1e-3, 200);  // 28 ms in ticks of 1 ms
  EXPECT_FALSE(judge(ticks, 1e-3, 0).accepted);
  const auto judged = judge(ticks, 1e-3, 7000);
  EXPECT_TRUE(judged.accepted) << judged.reason;
  EXPECT_EQ(judged.rate_hz, 7000);
  EXPECT_FALSE(judge(ticks, 1e-3, 9000).accepted) << "a stated rate that the stamps contradict";
}

/// 240 Hz with one frame missing after the 500th.
std::vector<std::int64_t> with_a_gap(double rate) {
  auto ticks = rounded_stamps(rate, 1e-6, 1001);
  ticks.erase(ticks.begin() + 500);
  return ticks;
}

TEST(ContainerTimestamps, AMissingFrameLeavesTheOthersTheirTimes) {
  const ContainerTimestamps stamps = judge_container_timestamps(with_a_gap(240), 1e-6, 0);
  EXPECT_TRUE(stamps.candidate.accepted) << stamps.candidate.reason;
  EXPECT_NEAR(stamps.candidate.rate_hz, 240, 0.03);
  ASSERT_EQ(stamps.check.missing.size(), 1u);
  EXPECT_EQ(stamps.check.missing[0].after, 499);
  const std::vector<double> times = frame_times(stamps, choose_time_base({stamps.candidate}));
  ASSERT_EQ(times.size(), 1000u);
  EXPECT_NEAR(times[499], 499 / 240.0, 1e-3);
  EXPECT_NEAR(times[500] - times[499], 2 / 240.0, 2e-6);
}

TEST(ContainerTimestamps, AGapInASlowedRecordingIsAGapInTheRealOne) {
  // Recorded at 240 Hz, stored to play at 29.97: the user's word sets the unit, the stamps show the gap.
  const ContainerTimestamps stamps = judge_container_timestamps(with_a_gap(30000.0 / 1001), 1e-6, 0);
  EXPECT_FALSE(stamps.candidate.accepted);
  EXPECT_THAT(stamps.candidate.reason, HasSubstr("playback rate"));
  EXPECT_TRUE(frame_times(stamps, choose_time_base({stamps.candidate})).empty());
  const std::vector<double> times = frame_times(stamps, choose_time_base({user_rate(240)}));
  ASSERT_EQ(times.size(), 1000u);
  EXPECT_DOUBLE_EQ(times[499], 499 / 240.0);
  EXPECT_DOUBLE_EQ(times[500], 501 / 240.0);
}

TEST(ContainerTimestamps, AVariableRateIsTakenStampByStamp) {
  std::vector<std::int64_t> ticks{0};
  for (int k = 0; k < 300; ++k) ticks.push_back(ticks.back() + 4000 + 37 * (k * k % 29));
  const ContainerTimestamps stamps = judge_container_timestamps(ticks, 1e-6, 0);
  EXPECT_TRUE(stamps.candidate.accepted) << stamps.candidate.reason;
  EXPECT_TRUE(stamps.check.variable);
  const std::vector<double> times = frame_times(stamps, choose_time_base({stamps.candidate}));
  ASSERT_EQ(times.size(), ticks.size());
  for (std::size_t k = 0; k < ticks.size(); ++k)
    EXPECT_NEAR(times[k], 1e-6 * static_cast<double>(ticks[k]), 1e-12);
  // A camera's tag of ten times the rate: slowed for playback, the spacing stays.
  const auto tagged = frame_times(
      stamps, choose_time_base({{"tag", 10 * stamps.candidate.rate_hz, true, "written by the camera"}}));
  EXPECT_NEAR(tagged.back(), times.back() / 10, 1e-12);
  // The user's word means even steps.
  EXPECT_TRUE(frame_times(stamps, choose_time_base({user_rate(240)})).empty());
}

TEST(ContainerTimestamps, UnevenOnesProveNothingOnCoarseTicksOrNearAPlaybackRate) {
  std::vector<std::int64_t> ticks{0};
  for (int k = 0; k < 300; ++k) ticks.push_back(ticks.back() + 3 + k % 3);
  EXPECT_THAT(judge(ticks, 1e-3, 0).reason, HasSubstr("too coarse"));
  ticks = {0};
  for (int k = 0; k < 300; ++k) ticks.push_back(ticks.back() + 33000 + 37 * (k * k % 29));
  EXPECT_FALSE(judge(ticks, 1e-6, 0).accepted);
  EXPECT_THAT(judge(ticks, 1e-6, 0).reason, HasSubstr("playback rate"));
  ticks[7] = ticks[6];
  EXPECT_THAT(judge(ticks, 1e-6, 0).reason, HasSubstr("do not rise"));
}

TEST(ContainerTimestamps, NothingToJudge) {
  EXPECT_FALSE(judge(std::vector<std::int64_t>{5}, 1e-3, 240).accepted);
  EXPECT_FALSE(judge(std::vector<std::int64_t>{5, 5, 5}, 1e-3, 240).accepted);
}

std::vector<double> times(const std::vector<std::pair<int, double>>& steps) {
  std::vector<double> out{0};
  for (const auto& [count, step] : steps)
    for (int k = 0; k < count; ++k) out.push_back(out.back() + step);
  return out;
}

TEST(StampCheck, EvenStampsAreUniform) {
  const StampCheck check = check_stamps(times({{100, 0.002}}), 1e-6);
  EXPECT_TRUE(check.uniform);
  EXPECT_NEAR(check.rate_hz, 500, 1e-9);
  EXPECT_THAT(findings(check, 0), IsEmpty());
}

TEST(StampCheck, MissingFramesAreCounted) {
  const StampCheck check =
      check_stamps(times({{40, 0.002}, {1, 0.004}, {30, 0.002}, {1, 0.010}, {9, 0.002}}), 1e-6);
  EXPECT_FALSE(check.uniform);
  EXPECT_FALSE(check.variable);
  ASSERT_EQ(check.missing.size(), 2u);
  EXPECT_EQ(check.missing[0].after, 40);
  EXPECT_EQ(check.missing[0].count, 1);
  EXPECT_EQ(check.missing[1].after, 71);
  EXPECT_EQ(check.missing[1].count, 4);
  EXPECT_EQ(check.stretches.size(), 1u);
  EXPECT_THAT(findings(check, -5), ElementsAre(HasSubstr("1 frame is missing between image 35 and 36"),
                                               HasSubstr("4 frames are missing between image 66 and 67")));
}

TEST(StampCheck, AChangeOfRateIsNoGap) {
  const StampCheck check = check_stamps(times({{50, 0.002}, {60, 0.0005}, {20, 0.004}}), 1e-6);
  ASSERT_EQ(check.stretches.size(), 3u);
  EXPECT_NEAR(check.stretches[1].rate_hz, 2000, 1e-6);
  EXPECT_EQ(check.stretches[1].first, 50);
  EXPECT_EQ(check.stretches[1].last, 110);
  EXPECT_THAT(check.missing, IsEmpty());
  EXPECT_THAT(findings(check, 0),
              ElementsAre(HasSubstr("500 Hz from image 0 to 50, 2000 Hz from image 50 to 110, "
                                    "250 Hz from image 110 to 130")));
}

TEST(StampCheck, AnImageFromAnotherDayIsAStray) {
  const StampCheck check = check_stamps(times({{233, 0.01}, {1, 2.5e7}}), 1e-6);
  EXPECT_THAT(check.strays, ElementsAre(234));
  EXPECT_THAT(findings(check, 0), ElementsAre(HasSubstr("image 234")));
}

TEST(StampCheck, JitterAllAlongIsAVariableRate) {
  const unsigned seed = 3;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> step(0.003, 0.006);
  std::vector<double> stamps{0};
  for (int k = 0; k < 200; ++k) stamps.push_back(stamps.back() + step(random));
  const StampCheck check = check_stamps(stamps, 1e-6);
  EXPECT_TRUE(check.variable);
  EXPECT_THAT(check.missing, IsEmpty());
  EXPECT_THAT(findings(check, 0), ElementsAre(HasSubstr("varies all along")));
}

TEST(StampCheck, NothingToCheck) {
  EXPECT_TRUE(check_stamps({}, 1e-6).uniform);
  EXPECT_TRUE(check_stamps(std::vector<double>{0}, 1e-6).uniform);
}

}  // namespace
}  // namespace tribotrack::vision
