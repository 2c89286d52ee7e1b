#include "apps/files/scope_file.h"

#include <gmock/gmock.h>

#include <cmath>

#include "apps/program.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

class ScopeFiles : public ProgramTest {
 protected:
  ScopeFile read(const std::string& text) {
    put(in_folder("s.csv"), text);
    return read_scope_file(in_folder("s.csv"));
  }
  std::string complaint(const std::string& text) {
    return complaint_of([&] { read(text); });
  }
};

/// 200 samples of two channels: V1 = n / 8, V2 = -n / 4, exact in decimal.
std::string rows(const char* separator, bool time_column, const std::string& end, bool decimal_comma) {
  std::string text;
  for (int n = 0; n < 200; ++n) {
    const auto number = [&](double v) {
      char digits[40];
      std::snprintf(digits, sizeof digits, "%.6e", v);
      std::string s = digits;
      if (decimal_comma) s.replace(s.find('.'), 1, ",");
      return s;
    };
    if (time_column) {
      // As the instrument prints them: four digits, so that neighbours share a time.
      char time[40];
      std::snprintf(time, sizeof time, "%.3e", -0.1 + 2e-5 * n);
      std::string s = time;
      if (decimal_comma) s.replace(s.find('.'), 1, ",");
      text += s + separator;
    }
    text += number(n / 8.0) + separator + number(-n / 4.0) + end + "\n";
  }
  return text;
}

std::string sequence_rows() {
  std::string text;
  for (int n = 0; n < 200; ++n)
    text += std::to_string(n) + "," + std::to_string(n / 8.0) + "," + std::to_string(-n / 4.0) + ",\n";
  return text;
}

void expect_ramps(const ScopeFile& file, double start, double increment, double tolerance) {
  EXPECT_EQ(file.names, (std::vector<std::string>{"CH1", "CH2"}));
  ASSERT_EQ(file.channels.size(), 2u);
  ASSERT_EQ(file.channels[0].size(), 200u);
  for (int n = 0; n < 200; ++n) {
    EXPECT_EQ(file.channels[0][n], n / 8.0);
    EXPECT_EQ(file.channels[1][n], -n / 4.0);
  }
  EXPECT_NEAR(file.start_s, start, tolerance);
  EXPECT_NEAR(file.increment_s, increment, tolerance / 199);
}

TEST_F(ScopeFiles, Ds1000z) {
  const ScopeFile file =
      read("X,CH1,CH2,Start,Increment,\nSequence,Volt,VOLT,-1.200000e-04,2.000000e-07\n" + sequence_rows());
  EXPECT_EQ(file.layout, "Rigol DS1000Z");
  expect_ramps(file, -1.2e-4, 2e-7, 0);
}

TEST_F(ScopeFiles, Ds1102e) {
  const ScopeFile file = read("Time,X(CH1),X(CH2)\nSecond,Volt,Volt\n" + rows(",", true, "", false));
  EXPECT_EQ(file.layout, "Rigol DS1102E");
  expect_ramps(file, -0.1, 2e-5, 1e-4);  // the printed times' last digit at both ends
}

TEST_F(ScopeFiles, Mso5000BothKinds) {
  expect_ramps(read("Time(s),CH1(V),CH2(V)\n" + rows(",", true, "", false)), -0.1, 2e-5, 1e-4);
  const ScopeFile file = read("CH1(V),CH2(V),t0 = -25s, tInc = 2e-06s,\n" + rows(",", false, ",", false));
  EXPECT_EQ(file.layout, "Rigol MSO5000");
  expect_ramps(file, -25, 2e-6, 0);
}

TEST_F(ScopeFiles, SemicolonsAndDecimalCommas) {
  expect_ramps(read("Time(s);CH1(V);CH2(V)\r\n" + rows(";", true, "\r", true)), -0.1, 2e-5, 1e-4);
}

TEST_F(ScopeFiles, RefusesWithFileAndLine) {
  const std::string good = "Time(s),CH1(V)\n";
  std::string bad = good;
  for (int n = 0; n < 200; ++n) bad += "0.1,0.2\n";
  EXPECT_THAT(complaint(bad), HasSubstr("greater than 0"));
  EXPECT_THAT(complaint(good + "0,1\n0.1,oops\n"), HasSubstr("s.csv:3:5: `oops` is not a number"));
  EXPECT_THAT(complaint(good + "0,1\n0.1\n"), HasSubstr("s.csv:3: has 1 columns where 2 belong"));
  EXPECT_THAT(complaint("a,b,c\n1,2,3\n"), HasSubstr("s.csv:1: is not a known oscilloscope layout"));
  EXPECT_THAT(complaint("Frequency,CH1\n1,2\n"), HasSubstr("s.csv:1: is not a known"));
  EXPECT_THAT(complaint(""), HasSubstr("empty"));
  EXPECT_THAT(complaint(good + "0,1\n1,2\n"), HasSubstr("at least 100"));
  EXPECT_THROW(read_scope_file(in_folder("none.csv")), InvalidInput);
}

}  // namespace
}  // namespace tribotrack::apps
