#include "apps/report/text/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace tribotrack::apps {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double pi = std::numbers::pi;

TEST(ReportText, EscapesWhatHtmlReads) {
  EXPECT_EQ(escape_html("<a href=\"x\">'&'</a>"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(escape_html("μ1 ± 2"), "μ1 ± 2");
}

TEST(ReportText, NumbersThatAreNotFiniteAreSaidInSigns) {
  EXPECT_EQ(number(nan), "–");
  EXPECT_EQ(number(infinity), "∞");
  EXPECT_EQ(number(-infinity), "−∞");
  EXPECT_EQ(number(-0.5), "−0.5");
  EXPECT_EQ(number(0.123456, 3), "0.123");
}

TEST(ReportText, AValueIsRoundedWhereItsSdHasTwoDigits) {
  EXPECT_EQ(value_and_sd(0.100123, 0.00031), "0.10012 ± 0.00031");
  EXPECT_EQ(value_and_sd(5.0263, 0.0139), "5.026 ± 0.014");
  EXPECT_EQ(value_and_sd(-3.14159, 0.2), "−3.14 ± 0.20");
  EXPECT_EQ(value_and_sd(1234.5, 57), "1234 ± 57");
  EXPECT_EQ(value_and_sd(1234.5, 1234), "1234 ± 1234");
}

TEST(ReportText, WithoutAnSdTheValueStandsAlone) {
  EXPECT_EQ(value_and_sd(0.1, nan), "0.1");
  EXPECT_EQ(value_and_sd(0.1, 0), "0.1");
  EXPECT_EQ(value_and_sd(0.1, infinity), "0.1");
  EXPECT_EQ(value_and_sd(nan, 0.1), "–");
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

TEST(ReportText, KnownParametersAreExplained) {
  EXPECT_EQ(parameter_words("mu1").symbol, "μ<sub>1</sub>");
  EXPECT_EQ(parameter_words("phase_lag_rad").unit, "rad");
  EXPECT_EQ(parameter_words("delay_s").unit, "s");
  EXPECT_EQ(parameter_words("<new>").symbol, "&lt;new&gt;");
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
