#include "apps/page/text.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace tribotrack::apps {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double pi = std::numbers::pi;

TEST(ReportText, AnIntervalKeepsTwoDigitsOfItsHalfWidth) {
  EXPECT_EQ(interval_text(0.09952, 0.100732, 0.00031), "0.09952 to 0.10073");
  EXPECT_EQ(interval_text(-0.001, infinity, 0.02), "−0.001 to ∞");
  EXPECT_EQ(interval_text(0.12341, 0.12351, 0.02), "0.123410 to 0.123510");
  EXPECT_EQ(interval_text(1, 3, nan), "1.0 to 3.0");
  EXPECT_EQ(interval_text(nan, 1, 0.1), "–");
}

TEST(ReportText, AnglesAreFractionsOfPiWhereTheyAre) {
  EXPECT_EQ(angle(0), "0");
  EXPECT_EQ(angle(pi), "π");
  EXPECT_EQ(angle(2 * pi), "2π");
  EXPECT_EQ(angle(pi / 3), "π/3");
  EXPECT_EQ(angle(11 * pi / 6), "11π/6");
  EXPECT_EQ(angle(-pi / 2), "−π/2");
  EXPECT_EQ(angle(7 * pi / 12 + 5e-5), "7π/12");
  EXPECT_EQ(angle(pi / 3 + 1e-3), "1.048 rad");
  EXPECT_EQ(angle(nan), "–");
}

// RFC 4648, section 10.
TEST(ReportText, Base64IsTheStandards) {
  const auto encoded = [](const std::string& text) { return base64({text.begin(), text.end()}); };
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foo"), "Zm9v");
  EXPECT_EQ(encoded("foob"), "Zm9vYg==");
  EXPECT_EQ(encoded("fooba"), "Zm9vYmE=");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64({0xff, 0xfb, 0xf0}), "//vw");
}

}  // namespace
}  // namespace tribotrack::apps
