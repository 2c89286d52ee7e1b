#include "apps/text/angle.h"

#include <gtest/gtest.h>

#include <numbers>

namespace tribotrack::apps {
namespace {

constexpr double pi = std::numbers::pi;

TEST(Angle, ReadsNumbersAndFractionsOfPi) {
  EXPECT_EQ(parse_angle("0.5"), 0.5);
  EXPECT_EQ(parse_angle("-37.5"), -37.5);
  EXPECT_EQ(parse_angle("1e-3"), 1e-3);
  EXPECT_EQ(parse_angle("pi"), pi);
  EXPECT_EQ(parse_angle("-pi/2"), -pi / 2);
  EXPECT_EQ(parse_angle("11pi/9"), 11 * pi / 9);
  EXPECT_EQ(parse_angle("5*pi/6"), 5 * pi / 6);
  EXPECT_EQ(parse_angle(" 2.5 pi "), 2.5 * pi);
  EXPECT_EQ(parse_angle("+pi"), pi);
}

TEST(Angle, ReadsDegreesThatAreMarkedAsSuch) {
  EXPECT_EQ(parse_angle("90deg"), pi / 2);
  EXPECT_EQ(parse_angle("-45 deg"), -pi / 4);
  EXPECT_EQ(parse_angle("22.5deg"), pi / 8);
  for (const char* text : {"deg", "pi deg", "90degrees", "90 DEG", "90de"})
    EXPECT_FALSE(parse_angle(text)) << text;
}

TEST(Angle, MoreThanTwoTurnsAreDegrees) {
  EXPECT_EQ(angle_slip(4 * pi), "");
  EXPECT_EQ(angle_slip(-4 * pi), "");
  EXPECT_EQ(angle_slip(90), "must lie within two turns (4 pi rad), not 90: degrees? write \"90deg\"");
  EXPECT_NE(angle_slip(-12.6), "");
}

TEST(Angle, RefusesEverythingElse) {
  for (const char* text : {"", "abc", "pi/", "pi/0", "pi2", "*pi", "pi/2/3", "nan", "inf", "-inf", "nanpi",
                           "1e400", "0x10", "1,5", "pi pi"})
    EXPECT_FALSE(parse_angle(text)) << text;
}

TEST(Number, TakesTheWholeTextOrNothing) {
  EXPECT_EQ(parse_number("+2.5"), 2.5);
  for (const char* text : {"", "2.5x", " 2.5", "nan", "inf", "--1"}) EXPECT_FALSE(parse_number(text)) << text;
}

}  // namespace
}  // namespace tribotrack::apps
