#include "vision/container_stamps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tribotrack::vision {
namespace {

using ::testing::HasSubstr;

std::vector<std::int64_t> rounded_stamps(double rate, double tick_s, int frames) {
  std::vector<std::int64_t> ticks;
  for (int k = 0; k < frames; ++k) ticks.push_back(std::llround(k / rate / tick_s));
  return ticks;
}

TEST(ContainerStamps, UniformTicksOfTheRateItselfAreBelieved) {
  const auto judged = judge_container_stamps(rounded_stamps(7000, 1.0 / 7000, 200), 1.0 / 7000, 0);
  EXPECT_TRUE(judged.accepted) << judged.reason;
  EXPECT_DOUBLE_EQ(judged.rate_hz, 7000);
}

TEST(ContainerStamps, PlaybackRatesAreNot) {
  for (const double rate : {25.0, 30000.0 / 1001, 60.0, 600.0, 1000.0, 65535.0}) {
    const auto judged = judge_container_stamps(rounded_stamps(rate, 1 / rate, 200), 1 / rate, rate);
    EXPECT_FALSE(judged.accepted) << rate;
    EXPECT_THAT(judged.reason, HasSubstr("playback rate"));
  }
}

TEST(ContainerStamps, CoarseTicksNeedTheContainersOwnRate) {
  const auto ticks = rounded_stamps(7000, 1e-3, 200);  // 28 ms in ticks of 1 ms
  EXPECT_FALSE(judge_container_stamps(ticks, 1e-3, 0).accepted);
  const auto judged = judge_container_stamps(ticks, 1e-3, 7000);
  EXPECT_TRUE(judged.accepted) << judged.reason;
  EXPECT_EQ(judged.rate_hz, 7000);
  EXPECT_FALSE(judge_container_stamps(ticks, 1e-3, 9000).accepted)
      << "a stated rate that the stamps contradict";
}

TEST(ContainerStamps, AJumpIsNotUniform) {
  auto ticks = rounded_stamps(240, 1e-5, 1000);
  for (std::size_t k = 500; k < ticks.size(); ++k) ticks[k] += 417;
  const auto judged = judge_container_stamps(ticks, 1e-5, 0);
  EXPECT_FALSE(judged.accepted);
  EXPECT_THAT(judged.reason, HasSubstr("not uniform"));
}

TEST(ContainerStamps, NothingToJudge) {
  EXPECT_FALSE(judge_container_stamps(std::vector<std::int64_t>{5}, 1e-3, 240).accepted);
  EXPECT_FALSE(judge_container_stamps(std::vector<std::int64_t>{5, 5, 5}, 1e-3, 240).accepted);
}

}  // namespace
}  // namespace tribotrack::vision
