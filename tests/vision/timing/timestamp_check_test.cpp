#include "vision/time_base.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace tribotrack::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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
