#include "fit/rounding.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tribotrack::fit {
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

TEST(Quoted, TheSdStandsInTheLastDigitsOfTheValue) {
  EXPECT_EQ(quoted(0.1000006, 2.9e-6), "0.1000006(29)");
  EXPECT_EQ(quoted(0.100123, 0.00031), "0.10012(31)");
  EXPECT_EQ(quoted(12.34, 1.2), "12.3(12)");
  EXPECT_EQ(quoted(1234, 25), "1234(25)");
  EXPECT_EQ(quoted(-0.2, 0.0996), "-0.20(10)");
  EXPECT_EQ(quoted(8.757e-27, 3.3e-28), "8.76(33)e-27");
}

TEST(Quoted, WhatIsNotKnownIsSaid) {
  EXPECT_EQ(quoted(0.1, INFINITY), "not determined");
  EXPECT_EQ(quoted(NAN, 0.1), "not determined");
  EXPECT_EQ(quoted(0.1, NAN), "not determined");
  EXPECT_EQ(quoted(0.28, 0), "0.28");
}

TEST(RoundedEnd, HalfTheWidthKeepsTwoDigits) {
  EXPECT_EQ(rounded_end(0.0999953, 0.0999953, 0.1000044, 2.3e-6), "0.0999953");
  EXPECT_EQ(rounded_end(0.10000441, 0.0999953, 0.10000441, 2.3e-6), "0.1000044");
  EXPECT_EQ(rounded_end(INFINITY, 0.05, INFINITY, 0.01), "open");
}

TEST(RoundedToSd, WithoutAnSdFourDigits) {
  EXPECT_EQ(rounded_to_sd(0.123456, 0), "0.1235");
}

}  // namespace
}  // namespace tribotrack::fit
