#include "apps/files/traces/scope_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
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

/// What every layout below holds: V1 = n / 8, V2 = -n / 4 from -0.1 s on, every 2e-5 s.
std::string printed(int n, const char* separator, double second = 1, double volt2 = 1) {
  char line[120];
  std::snprintf(line, sizeof line, "%.9g%s%.9g%s%.9g", (-0.1 + 2e-5 * n) / second, separator, n / 8.0,
                separator, -n / 4.0 / volt2);
  return line;
}
std::string all(const char* separator, double second = 1, double volt2 = 1, const char* end = "\n") {
  std::string text;
  for (int n = 0; n < 200; ++n) text += printed(n, separator, second, volt2) + end;
  return text;
}

void expect_near_ramps(const ScopeFile& file, const std::vector<std::string>& names) {
  EXPECT_EQ(file.names, names);
  ASSERT_EQ(file.channels.size(), names.size());
  ASSERT_EQ(file.channels[0].size(), 200u);
  for (int n = 0; n < 200; ++n) {
    EXPECT_NEAR(file.channels[0][n], n / 8.0, 1e-9);
    if (names.size() > 1) {
      EXPECT_NEAR(file.channels[1][n], -n / 4.0, 1e-9);
    }
  }
  EXPECT_NEAR(file.start_s, -0.1, 1e-9);
  EXPECT_NEAR(file.increment_s, 2e-5, 1e-12);
}

TEST_F(ScopeFiles, Tektronix) {
  const ScopeFile file = read(
      "Model,MSO4034\nFirmware Version,2.48\n\nWaveform Type,ANALOG,,\nPoint Format,Y,,\nHorizontal "
      "Units,s,,\n"
      "Horizontal Scale,4e-06,,\nHorizontal Delay,0,,\nSample Interval,2e-05,,\nRecord Length,200,,\n"
      "Gating,0.0% to 100.0%,,\nProbe Attenuation,10,10\nVertical Units,V,V\nVertical "
      "Offset,0,0\n,,\n,,\nLabel,,\n"
      "TIME,CH1,CH2\n" +
      all(","));
  EXPECT_EQ(file.layout, "Tektronix");
  expect_near_ramps(file, {"CH1", "CH2"});
  EXPECT_EQ(file.increment_s, 2e-5);  // the settings have all digits
}

TEST_F(ScopeFiles, TektronixWithDigitalLinesAndMillivolts) {
  std::string text = "Model,MDO3014\nVertical Units,V,mV,V\nLabel,a,b,c\nTIME,CH1,CH3,D0\n";
  for (int n = 0; n < 200; ++n) text += printed(n, ",", 1, 1e-3) + ",1\n";
  expect_near_ramps(read(text), {"CH1", "CH3"});
}

TEST_F(ScopeFiles, TektronixTds) {
  const char* settings[] = {"Record Length,2.000000e+02",
                            "Sample Interval,2.000000e-05",
                            "Trigger Point,1.0e+02",
                            "",
                            "",
                            "",
                            "Source,CH1",
                            "Vertical Units,V",
                            "Vertical Scale,2.0e+00"};
  std::string text, quoted;
  for (int n = 0; n < 200; ++n) {
    char numbers[80];
    std::snprintf(numbers, sizeof numbers, "%013.9f, %9.5f", -0.1 + 2e-5 * n, n / 8.0);
    const std::string setting = n < 9 ? settings[n] : "";
    text += (setting.empty() ? "," : setting) + ",," + numbers + ",\n";
    quoted += std::string(n == 0 ? "\"Record Length\",  200,\"Points\"" : ",,") + ", " + numbers + "\n";
  }
  for (const std::string& layout : {text, quoted}) {
    const ScopeFile file = read(layout);
    EXPECT_EQ(file.layout, "Tektronix TDS");
    expect_near_ramps(file, {"CH1"});
  }
}

TEST_F(ScopeFiles, Keysight) {
  const ScopeFile file = read("x-axis,1,2\nsecond,Volt,Volt\n-0.1,,\n-0.1,,\n" + all(","));
  EXPECT_EQ(file.layout, "Keysight");
  expect_near_ramps(file, {"CH1", "CH2"});
}

TEST_F(ScopeFiles, Siglent) {
  const ScopeFile old = read(
      "Record Length,Analog:200\nSample Rate,50000.0\nVertical Scale,CH1: 0.05,CH2: 1\nVertical "
      "Offset,CH1:0.0\n"
      "Horizontal Scale,0.00001\nSecond,Volt,Volt\n" +
      all(","));
  EXPECT_EQ(old.layout, "Siglent");
  expect_near_ramps(old, {"CH1", "CH2"});
  const ScopeFile recent = read(
      "Record Length,Analog:200,\nSample Interval,Analog:2.000000E-05,\nVertical Units,CH1:V,CH3:mV,,\n"
      "Horizontal Units,s,\nModel Number,SDS1104X-U,\nSource,CH1,CH3\nSecond,Value,Value\n" +
      all(",", 1, 1e-3));
  EXPECT_EQ(recent.layout, "Siglent");
  expect_near_ramps(recent, {"CH1", "CH3"});
  expect_near_ramps(read("Source,CH1,CH2\nSecond,Volt,Volt\n" + all(",")), {"CH1", "CH2"});
}

TEST_F(ScopeFiles, PicoScope) {
  const ScopeFile file = read("Time,Channel A,Channel B\n(ms),(V),(mV)\n\n" + all(",", 1e-3, 1e-3));
  EXPECT_EQ(file.layout, "PicoScope");
  expect_near_ramps(file, {"Channel A", "Channel B"});
  std::string german = "Zeit;Kanal A;Kanal B\n(us);(V);(mV)\n\n" + all(";", 1e-6, 1e-3);
  std::replace(german.begin(), german.end(), '.', ',');
  expect_near_ramps(read(german), {"Kanal A", "Kanal B"});
  EXPECT_THAT(complaint("Time,Channel A\n(ms),(V)\n\n0,1\n1,\xe2\x88\x9e\n"),
              HasSubstr("s.csv:5:3: the signal was beyond the channel's range"));
}

TEST_F(ScopeFiles, PlainTables) {
  for (const char* header : {"Time,CH1,CH2\n", "t_s,sensor,burst\n", "time (s),sensor [V],burst [V]\n"}) {
    const ScopeFile file = read(header + all(","));
    EXPECT_EQ(file.layout, "Time, channels") << header;
    EXPECT_EQ(file.channels.size(), 2u);
  }
  expect_near_ramps(read("t_ms\tCH1 (V)\tCH2 (mV)\n" + all("\t", 1e-3, 1e-3)), {"CH1", "CH2"});
}

TEST_F(ScopeFiles, SamplesMustBeEven) {
  std::string gap = "Time,CH1,CH2\n", back = gap;
  for (int n = 0; n < 400; ++n) {
    gap += printed(n < 200 ? n : n + 50, ",") + "\n";
    back += printed(n < 200 ? n : n - 100, ",") + "\n";
  }
  EXPECT_THAT(complaint(gap), HasSubstr("its samples are not evenly spaced"));
  EXPECT_THAT(complaint(back), HasSubstr("its times go back at sample 201"));
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

TEST_F(ScopeFiles, OfOneChannelEachAreJoined) {
  const auto trace = [](double start, double step, int samples, double level) {
    std::string text = "Time(s),CH1(V)\n";
    for (int n = 0; n < samples; ++n) text += fmt::format("{:.9f},{}\n", start + step * n, level + n);
    return text;
  };
  ScopeFile first = read(trace(0.5, 1e-3, 200, 0));
  add_channels(read(trace(0.5, 1e-3, 200, 1000)), first);
  ASSERT_EQ(first.channels.size(), 2U);
  EXPECT_EQ(first.names.size(), 2U);
  EXPECT_EQ(first.channels[0][7], 7);
  EXPECT_EQ(first.channels[1][7], 1007);
  for (const auto& other : {trace(0.6, 1e-3, 200, 0), trace(0.5, 1.1e-3, 200, 0), trace(0.5, 1e-3, 199, 0)})
    EXPECT_THAT(complaint_of([&] { add_channels(read(other), first); }), HasSubstr("not of the same trace"));
}

}  // namespace
}  // namespace tribotrack::apps
