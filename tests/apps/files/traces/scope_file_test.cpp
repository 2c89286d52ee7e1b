#include "apps/files/traces/scope_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using Names = std::vector<std::string>;

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

/// How an oscilloscope prints 200 samples of two channels, V1 = n / 8 and V2 = -n / 4 from -0.1 s on, every
/// 2e-5 s: {0} is n, {1} the time, {2} and {3} the voltages.
struct Print {
  const char* line = "{1:.9g},{2},{3}\n";
  double second = 1, volt2 = 1;  ///< in units of the file
  bool decimal_comma = false;
};
std::string samples(const Print& print = {}) {
  std::string text;
  for (int n = 0; n < 200; ++n)
    text += fmt::format(fmt::runtime(print.line), n, (-0.1 + 2e-5 * n) / print.second, n / 8.0,
                        -n / 4.0 / print.volt2);
  if (print.decimal_comma) std::replace(text.begin(), text.end(), '.', ',');
  return text;
}

struct Layout {
  std::string name, text;
  Names channels = {"CH1", "CH2"};
  double start = -0.1, increment = 2e-5;
  double rounding = 1e-9;  ///< of the printed times, s
};

/// The first 9 lines hold settings beside the numbers.
std::string tektronix_tds() {
  const Names settings = {"Record Length,2.000000e+02",
                          "Sample Interval,2.000000e-05",
                          "Trigger Point,1.0e+02",
                          "",
                          "",
                          "",
                          "Source,CH1",
                          "Vertical Units,V",
                          "Vertical Scale,2.0e+00"};
  std::string text;
  for (std::size_t n = 0; n < 200; ++n)
    text += fmt::format("{},,{:013.9f}, {:9.5f},\n", n < 9 && !settings[n].empty() ? settings[n] : ",",
                        -0.1 + 2e-5 * static_cast<double>(n), static_cast<double>(n) / 8);
  return text;
}

std::vector<Layout> layouts() {
  // As these instruments print times: four digits, so that neighbours share one.
  const std::string coarse = samples({"{1:.3e},{2:.6e},{3:.6e}\n"});
  return {
      {"Rigol DS1000Z",
       "X,CH1,CH2,Start,Increment,\nSequence,Volt,VOLT,-1.200000e-04,2.000000e-07\n" +
           samples({"{0},{2},{3},\n"}),
       {"CH1", "CH2"},
       -1.2e-4,
       2e-7},
      {"time and channels",
       "Time,X(CH1),X(CH2)\nSecond,Volt,Volt\n" + coarse,
       {"CH1", "CH2"},
       -0.1,
       2e-5,
       1e-4},
      {"time and channels", "Time(s),CH1(V),CH2(V)\n" + coarse, {"CH1", "CH2"}, -0.1, 2e-5, 1e-4},
      {"Rigol MSO5000",
       "CH1(V),CH2(V),t0 = -25s, tInc = 2e-06s,\n" + samples({"{2:.6e},{3:.6e},\n"}),
       {"CH1", "CH2"},
       -25,
       2e-6},
      {"time and channels",
       "Time(s);CH1(V);CH2(V)\r\n" + samples({"{1:.3e};{2:.6e};{3:.6e}\r\n", 1, 1, true}),
       {"CH1", "CH2"},
       -0.1,
       2e-5,
       1e-4},
      {"time and channels",
       "Model,MSO4034\nFirmware Version,2.48\n\nWaveform Type,ANALOG,,\nPoint Format,Y,,\nHorizontal "
       "Units,s,,\nHorizontal Scale,4e-06,,\nHorizontal Delay,0,,\nSample Interval,2e-05,,\nRecord "
       "Length,200,,\nGating,0.0% to 100.0%,,\nProbe Attenuation,10,10\nVertical Units,V,V\nVertical "
       "Offset,0,0\n,,\n,,\nLabel,,\nTIME,CH1,CH2\n" +
           samples()},
      {"time and channels",
       "Model,MDO3014\nVertical Units,V,mV,V\nLabel,a,b,c\nTIME,CH1,CH3,D0\n" +
           samples({"{1:.9g},{2},{3},1\n", 1, 1e-3}),
       {"CH1", "CH3"}},
      {"Tektronix TDS", tektronix_tds(), {"CH1"}},
      {"time and channels", "x-axis,1,2\nsecond,Volt,Volt\n-0.1,,\n-0.1,,\n" + samples()},
      {"time and channels",
       "Record Length,Analog:200\nSample Rate,50000.0\nVertical Scale,CH1: 0.05,CH2: 1\nVertical "
       "Offset,CH1:0.0\nHorizontal Scale,0.00001\nSecond,Volt,Volt\n" +
           samples()},
      {"time and channels",
       "Record Length,Analog:200,\nSample Interval,Analog:2.000000E-05,\nVertical Units,CH1:V,CH3:mV,,\n"
       "Horizontal Units,s,\nModel Number,SDS1104X-U,\nSource,CH1,CH3\nSecond,Value,Value\n" +
           samples({"{1:.9g},{2},{3}\n", 1, 1e-3}),
       {"CH1", "CH3"}},
      {"time and channels", "Source,CH1,CH2\nSecond,Volt,Volt\n" + samples()},
      {"time and channels",
       "Time,Channel A,Channel B\n(ms),(V),(mV)\n\n" + samples({"{1:.9g},{2},{3}\n", 1e-3, 1e-3}),
       {"Channel A", "Channel B"}},
      {"time and channels",
       "Zeit;Kanal A;Kanal B\n(us);(V);(mV)\n\n" + samples({"{1:.9g};{2};{3}\n", 1e-6, 1e-3, true}),
       {"Kanal A", "Kanal B"}},
      {"time and channels", "Time,CH1,CH2\n" + samples()},
      {"time and channels", "t_s,sensor,burst\n" + samples(), {"sensor", "burst"}},
      {"time and channels", "time (s),sensor [V],burst [V]\n" + samples(), {"sensor", "burst"}},
      {"time and channels", "in s,CH1 in V,CH2 in V\n" + samples()},
      {"time and channels", "CH1 (V),CH2 (V),t (s)\n" + samples({"{2},{3},{1:.9g}\n"})},
      {"time and channels", "time\tV(a)\tV(b)\n" + samples({"{1:.15e}\t{2:.6e}\t{3:.6e}\n"}), {"V", "V"}},
      {"time and channels",
       "#Digilent WaveForms Oscilloscope Acquisition\n\nTime (s),Channel 1 (V),Channel 2 (V)\n" + samples(),
       {"Channel 1", "Channel 2"}},
      {"time and channels",
       "LECROYWS3024,51234,Waveform\nSegments,1,SegmentSize,200\nSegment,TrigTime,TimeSinceSegment1\n"
       "#1,01-Jan-2020 12:00:00,0\nTime,Ampl,Ampl2\n" +
           samples(),
       {"Ampl", "Ampl2"}},
      {"time and channels", "t_ms\tCH1 (V)\tCH2 (mV)\n" + samples({"{1:.9g}\t{2}\t{3}\n", 1e-3, 1e-3})},
  };
}

TEST_F(ScopeFiles, EveryLayoutGivesTheSameSamples) {
  for (const Layout& layout : layouts()) {
    SCOPED_TRACE(layout.name + ": " + layout.text.substr(0, layout.text.find('\n')));
    const ScopeFile file = read(layout.text);
    EXPECT_EQ(file.layout, layout.name);
    EXPECT_EQ(file.names, layout.channels);
    ASSERT_EQ(file.channels.size(), layout.channels.size());
    ASSERT_EQ(file.channels[0].size(), 200u);
    for (int n = 0; n < 200; ++n) {
      EXPECT_NEAR(file.channels[0][n], n / 8.0, 1e-9);
      if (file.channels.size() > 1) {
        EXPECT_NEAR(file.channels[1][n], -n / 4.0, 1e-9);
      }
    }
    EXPECT_NEAR(file.start_s, layout.start, layout.rounding);
    EXPECT_NEAR(file.increment_s, layout.increment, layout.rounding / 199);
  }
}

TEST_F(ScopeFiles, SamplesMustBeEven) {
  std::string gap = "Time,CH1\n", back = gap;
  for (int n = 0; n < 400; ++n) {
    gap += fmt::format("{},1\n", 2e-5 * (n < 200 ? n : n + 50));
    back += fmt::format("{},1\n", 2e-5 * (n < 200 ? n : n - 100));
  }
  EXPECT_THAT(complaint(gap), HasSubstr("s.csv: its samples are not evenly spaced"));
  EXPECT_THAT(complaint(back), HasSubstr("s.csv: its times go back at sample 201"));
  EXPECT_THAT(complaint("Time,Channel A\n(ms),(V)\n\n0,1\n1,\xe2\x88\x9e\n"), HasSubstr("s.csv:5:3"));
}

TEST_F(ScopeFiles, OfOneChannelEachAreJoined) {
  const auto trace = [](double start, double step, int count, double level) {
    std::string text = "Time(s),CH1(V)\n";
    for (int n = 0; n < count; ++n) text += fmt::format("{:.9f},{}\n", start + step * n, level + n);
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
