#include "apps/text/number_text.h"

#include <gtest/gtest.h>

namespace tribotrack::apps {
namespace {

TEST(RoundedToSd, TheSdKeepsTwoDigitsAndTheValueItsPlace) {
  EXPECT_EQ(rounded_to_sd(0.100123, 0.00031), "0.10012");
  EXPECT_EQ(rounded_to_sd(0.00031, 0.00031), "0.00031");
  EXPECT_EQ(rounded_to_sd(0.2, 5e-5), "0.200000");
  EXPECT_EQ(rounded_to_sd(5e-5, 5e-5), "0.000050");
  EXPECT_EQ(rounded_to_sd(-3.14159, 0.2), "-3.14");
  EXPECT_EQ(rounded_to_sd(1234.5, 57), "1234");
}

// 0.0996 is 0.10 in two digits, not 0.100.
TEST(RoundedToSd, AnSdThatRoundsUpToAPowerOfTenKeepsTwoDigits) {
  EXPECT_EQ(rounded_to_sd(0.0996, 0.0996), "0.10");
  EXPECT_EQ(rounded_to_sd(1.2345, 0.0996), "1.23");
}

TEST(RoundedToSd, VerySmallAndLargeOnesArePowersOfTen) {
  EXPECT_EQ(rounded_to_sd(8.757e-27, 3.3e-28), "8.76e-27");
  EXPECT_EQ(rounded_to_sd(3.3e-28, 3.3e-28), "3.3e-28");
  EXPECT_EQ(rounded_to_sd(0.05, 2414865), "5e-02");
  EXPECT_EQ(rounded_to_sd(2414865, 2414865), "2.4e+06");
}

TEST(RoundedToSd, WithoutAnSdFourDigits) {
  EXPECT_EQ(rounded_to_sd(0.123456, 0), "0.1235");
}

}  // namespace
}  // namespace tribotrack::apps
