// Tables in the manner of the programs that write them: the first and the last row, wherever and however they
// stand.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>

#include "apps/files/campaign/campaign.h"
#include "apps/files/traces/scope_file.h"
#include "apps/files/tracks/any_track.h"
#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

constexpr int kRows = 200;
constexpr double kRate = 50;

/// A part that goes along an arc: millimetres, y up, as every file below holds it.
Eigen::Vector2d place(int k) {
  return {20 + 0.05 * k, 3 + 0.0001 * k * k};
}

std::string rows(const std::function<std::string(int, double, Eigen::Vector2d)>& row,
                 bool decimal_comma = false) {
  std::string text;
  for (int k = 0; k < kRows; ++k) text += row(k, k / kRate, place(k));
  if (decimal_comma) std::ranges::replace(text, '.', ',');
  return text;
}

std::string in(const char* format, bool decimal_comma = false, double second = 1) {
  return rows(
      [&](int k, double t, Eigen::Vector2d p) {
        return fmt::format(fmt::runtime(format), t * second, p.x(), p.y(), k);
      },
      decimal_comma);
}

/// Two points in turn, the second one 5 mm to the right.
std::string twice(const char* format) {
  return rows([&](int k, double t, Eigen::Vector2d p) {
    return fmt::format(fmt::runtime(format), t, p.x(), p.y(), p.x() + 5, k);
  });
}

struct Sample {
  std::string program, text;
  TrackReading reading = {};
};

TrackReading reading(const std::string& unit, std::optional<double> mm_per_px = {},
                     const std::string& point = "") {
  TrackReading how;
  how.unit = unit;
  how.mm_per_px = mm_per_px;
  how.point = point;
  how.y = "up";
  return how;
}

std::vector<Sample> tracks() {
  const TrackReading mm = reading("mm"), none;
  TrackReading frames = reading("px", 1.0);
  frames.frame_rate_hz = kRate;
  TrackReading other = frames;
  other.point = "3";
  TrackReading fifty;
  fifty.frame_rate_hz = kRate;
  const std::string prose =
      "Recorded on Monday, at 20 degrees; x and y were measured\nwith a new lamp, 3 m away\n\n";
  std::string long_preamble;
  for (int k = 0; k < 300; ++k) long_preamble += fmt::format("setting {},value {}\n", k, k);
  return {
      {"Tracker", "mass_A\t\t\nt\tx\ty\n" + in("{:.9E}\t{:.9E}\t{:.9E}\n"), mm},
      {"Tracker, German", "mass_A;;\nt;x;y\n" + in("{:.4f};{:.6f};{:.6f}\n", true), mm},
      {"Tracker's data tool", "t_{1}\tx_{1}\ty_{1}\tamp\n" + in("{}\t{}\t{}\t0.5\n"), mm},
      {"Tracker, two masses", "#multi:\n,mass A,,mass B,\nt,x,y,x,y\n" + twice("{0},{1},{2},{3},{2}\n"),
       reading("mm", {}, "mass A")},
      {"Kinovea", "Time (ms);Disc X;Disc Y\n" + in("{:.0f};{:.6f};{:.6f}\n", true, 1e3), mm},
      {"Kinovea, text",
       "#Kinovea Trajectory data export\n#T X Y\n\n# Trajectory 1\n" +
           in("{:.0f} {:.6f} {:.6f}\n", false, 1e3) + "\n",
       mm},
      {"Kinovea, two texts",
       "#Kinovea Trajectory data export\n#T X Y\n\n# part\n" + in("{:.0f} {:.6f} {:.6f}\n", false, 1e3) +
           "\n# other\n0 1 2\n20 1 2\n",
       reading("mm", {}, "part")},
      {"Kinovea, two older",
       "#Kinovea Trajectory data export\n#T X Y\n" + in("{:.0f} {:.6f} {:.6f}\n", false, 1e3) +
           "\n0 1 2\n20 1 2\n",
       reading("mm", {}, "1")},
      {"Kinovea, older",
       "#Kinovea Trajectory data export\n#T X Y\n" + rows([](int k, double, Eigen::Vector2d p) {
         return fmt::format("0:00:{:02}:{:02} {:.6f} {:.6f} \n", k / 50, 2 * (k % 50), p.x(), p.y());
       }),
       mm},
      {"ImageJ results", " \tLabel\tArea\tX\tY\tSlice\n" + in("{3}\tdisc\t100\t{1}\t{2}\t{3}\n"), frames},
      {"ImageJ manual tracking",
       " \tTrack n\xb0\tSlice n\xb0\tX\tY\tDistance\tVelocity\n" + in("{3}\t1\t{3}\t{1}\t{2}\t0.1\t2\n"),
       frames},
      {"TrackMate",
       "LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME\nLabel,Spot ID,Track "
       "ID,Quality,X,Y,Z,T,Frame\n"
       "Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame\n,,,(quality),(micron),(micron),(micron),(sec),\n" +
           rows([](int k, double t, Eigen::Vector2d p) {
             return fmt::format("ID{0},{0},0,5.1,{1},{2},0,{3},{0}\n", k, 1e3 * p.x(), 1e3 * p.y(), t);
           }),
       reading("")},
      {"trackpy", ",y,x,mass,frame,particle\n" + in("{3},{2},{1},500.5,{3},3\n") + "7,1,1,5,0,4\n", other},
      {"DLTdv", "pt1_cam1_X,pt1_cam1_Y\n" + in("{1},{2}\n"), frames},
      {"a spreadsheet, German",
       "sep=;\r\nZeit in ms;x in mm;y in mm\r\n" + in("{:.1f};{:.6f};{:.6f}\r\n", true, 1e3), none},
      {"a spreadsheet, quoted",
       "\"t (s)\",\"x (mm)\",\"y (mm)\"\n" + in("\"{:.2f}\",\"{:.6f}\",\"{:.6f}\"\n", true), none},
      {"R", "\"t_s\" \"x_mm\" \"y_mm\"\n" + in("\"{3}\" {0} {1} {2}\n"), none},
      {"numpy.savetxt", "# t_s x_mm y_mm\n" + in("{:.18e} {:.18e} {:.18e}\n"), none},
      {"comments anywhere",
       "# t, x, y of the lamp\nt_s,x_mm,y_mm\n% from here on\n0,20,3\n\n# the lamp was moved\n" +
           in("{},{},{}\n").substr(7),
       none},
      {"prose above", prose + "t_s,x_mm,y_mm\n" + in("{},{},{}\n"), none},
      {"a long preamble", long_preamble + "t_s,x_mm,y_mm\n" + in("{},{},{}\n"), none},
      {"hyphens", "Frame #,X-Position (mm),Y-coordinate (mm)\n" + in("{3},{1},{2}\n"), fifty},
      {"units below", "y;t;x\n(mm);(s);(mm)\n" + in("{2};{0};{1}\n"), none},
      {"units beside, in blanks", "Time (s)  x (mm)  y (mm)\n" + in(" {:.2f}   {:.6f}  {:.6f}\n"), none},
      {"time in the last column", "x_mm,y_mm,t_s\n" + in("{1},{2},{0}\n"), none},
      {"subscripts",
       "t (s),x\u2081 (mm),y\u2081 (mm),x\u2082 (mm),y\u2082 (mm)\n" + twice("{0},{1},{2},{3},{2}\n"),
       reading("", {}, "1")},
      {"names of points",
       "t (s);point A: x (mm);point A: y (mm);point B: x (mm);point B: y (mm)\n" +
           twice("{0};{1};{2};{3};{2}\n"),
       reading("", {}, "point_a")},
      {"classic Mac", "t_s,x_mm,y_mm\r" + rows([](int, double t, Eigen::Vector2d p) {
                        return fmt::format("{},{},{}\r", t, p.x(), p.y());
                      }),
       none},
  };
}

class ForeignTables : public ProgramTest {
 protected:
  /// A campaign whose alpha and v stand in x.csv.
  Campaign with_table() const {
    put(in_folder("c.toml"), "[data]\ntable = \"x.csv\"\nalpha_sd_rad = 0.02\nv_sd_mm_s = 0.1\n");
    return read_campaign(in_folder("c.toml"));
  }
};

TEST_F(ForeignTables, TracksOfEveryProgramHaveTheirFirstAndLastRow) {
  for (const Sample& sample : tracks()) {
    SCOPED_TRACE(sample.program);
    put(in_folder("x.csv"), sample.text);
    Track track;
    try {
      track = read_any_track(in_folder("x.csv"), sample.reading);
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
      continue;
    }
    ASSERT_EQ(track.table.time.size(), static_cast<std::size_t>(kRows));
    EXPECT_NEAR(track.table.time.back() - track.table.time.front(), (kRows - 1) / kRate, 1e-6);
    const Eigen::Vector2d moved = track.table.position.back() - track.table.position.front();
    EXPECT_NEAR(1e3 * moved.x(), place(kRows - 1).x() - place(0).x(), 2e-6);
    EXPECT_NEAR(1e3 * std::abs(moved.y()), place(kRows - 1).y() - place(0).y(), 2e-6);
  }
}

TEST_F(ForeignTables, TracesOfEveryOscilloscopeHaveTheirFirstAndLastSample) {
  const auto samples = [](const char* format, bool decimal_comma = false) {
    std::string text;
    for (int k = 0; k < kRows; ++k)
      text += fmt::format(fmt::runtime(format), -0.1 + 2e-5 * k, 4.5 - 0.01 * k, 0.25 * k);
    if (decimal_comma) std::ranges::replace(text, '.', ',');
    return text;
  };
  const std::vector<std::pair<std::string, std::string>> traces = {
      {"Digilent",
       "#Digilent WaveForms Oscilloscope Acquisition\n#Device Name: ADP3450\n#Serial Number: SN:0\n"
       "#Date Time: 2021-04-14 13:10:34.255\n\nTime (s),Channel 1 (V),Channel 2 (V)\n" +
           samples("{:.12f},{:.14f},{:.14f}\n")},
      {"LTspice", "time\tV(sensor)\tV(burst)\n" + samples("{:.15e}\t{:.6e}\t{:.6e}\n")},
      {"LeCroy",
       "LECROYWS3024,51234,Waveform\nSegments,1,SegmentSize,200\nSegment,TrigTime,TimeSinceSegment1\n#1,01-"
       "Jan-2020 12:00:00,0\n"
       "Time,Ampl,Ampl2\n" +
           samples("{:.9f},{},{}\n")},
      {"Rohde & Schwarz", "in s,CH1 in V,CH2 in V\n" + samples("{:.9f},{},{}\n")},
      {"Excel, German", "Messung 7;;\nZeit (s);Sensor (V);Burst (V)\n" + samples("{:.9f};{};{}\n", true)},
      {"time last", "sensor (V),burst (V),t (s)\n" + samples("{1},{2},{0:.9f}\n")},
  };
  for (const auto& [program, text] : traces) {
    SCOPED_TRACE(program);
    put(in_folder("s.csv"), text);
    const ScopeFile trace = read_scope_file(in_folder("s.csv"));
    ASSERT_EQ(trace.channels.size(), 2u);
    ASSERT_EQ(trace.channels[0].size(), static_cast<std::size_t>(kRows));
    EXPECT_NEAR(trace.start_s, -0.1, 1e-9);
    EXPECT_NEAR(trace.increment_s, 2e-5, 1e-11);
    EXPECT_NEAR(trace.channels[0].front(), 4.5, 1e-9);
    EXPECT_NEAR(trace.channels[0].back(), 4.5 - 0.01 * (kRows - 1), 1e-9);
    EXPECT_NEAR(trace.channels[1].back(), 0.25 * (kRows - 1), 1e-9);
  }
}

TEST_F(ForeignTables, AlphaAndVOfEverySpreadsheet) {
  for (const std::string text :
       {"phi_deg,dtau_deg,alpha_deg,v_mm_s\n0,60,340,1.5\n90deg,60,250,1.7\n",
        "Messung vom Montag;;;\n# alles mit neuer Lampe\nphi (\u00b0);\u0394\u03c4 (\u00b0);\u03b1 "
        "(\u00b0);v (mm/s)\n0;60;340;1,5\n90;60;250;1,7\n",
        "name\tv\tphi\tdtau\talpha\n\t[mm/s]\t[deg]\t[deg]\t[deg]\na\t1.5\t0\t60\t340\nb\t1.7\t90\t60\t250\n",
        "alpha_rad phi_rad dtau_rad v_m_s\n5.934119456780721 0 pi/3 0.0015\n4.363323129985824 pi/2 pi/3 "
        "0.0017\n"}) {
    SCOPED_TRACE(text);
    put(in_folder("x.csv"), text);
    const Campaign table = with_table();
    ASSERT_EQ(table.runs.size(), 2u);
    EXPECT_NEAR(*table.runs[0].alpha, 340 * M_PI / 180, 1e-9);
    EXPECT_NEAR(*table.runs[0].v, 1.5e-3, 1e-12);
    EXPECT_NEAR(table.runs[1].phi, M_PI / 2, 1e-9);
    EXPECT_NEAR(*table.runs[1].v, 1.7e-3, 1e-12);
  }
}

TEST_F(ForeignTables, ARefusalSaysWhatTheTableHolds) {
  const auto refusal = [&](const auto& read, const std::string& text) {
    put(in_folder("x.csv"), text);
    return complaint_of([&] { read(in_folder("x.csv")); });
  };
  const auto track = [](const std::filesystem::path& path) { read_any_track(path, {}); };
  const auto scope = [](const std::filesystem::path& path) { read_scope_file(path); };
  const auto alpha_v = [&](const std::filesystem::path&) { with_table(); };
  const std::string other = "# lab\nTemperatur;Druck\n20,5;1\n21,5;2\n";
  const std::string holds =
      "it holds rows of 2 columns from line 3 on, separated by semicolons, with decimal commas under "
      "`Temperatur`, `Druck`";
  EXPECT_THAT(refusal(track, other), HasSubstr(holds));
  EXPECT_THAT(refusal(scope, other), HasSubstr(holds));
  EXPECT_THAT(refusal(alpha_v, other), HasSubstr(holds));
  EXPECT_THAT(refusal(track, "0.1 1 2\n0.2 1 2\n"),
              HasSubstr("it holds rows of 3 columns from line 1 on, separated by blanks"));
  EXPECT_THAT(refusal(track, "t_s,x_mm,y_mm\n0,00,20,05,3,00\n0,02,20,10,3,01\n"),
              HasSubstr("x.csv:2:9: has 6 cells under 3 columns; is a decimal comma among them?"));
  EXPECT_THAT(refusal(track, "Time (s) Disc X Disc Y\n0 1 2\n0.1 1 3\n"),
              HasSubstr("x.csv:1: has 5 names above 3 columns"));
  EXPECT_THAT(refusal(track, "Dear colleague,\nhere is it\n"), HasSubstr("begins with `Dear colleague,`"));
  EXPECT_THAT(refusal(track, "t,x_mm,y_mm\n00:00:01:03,1,2\n00:00:01:04,1,2\n"),
              HasSubstr("counts frames; export times in s"));
}

TEST_F(ForeignTables, WhoseFrameATrackIsInCanBeSaid) {
  put(in_folder("x.csv"), "t_s,x_mm,y_mm,marker_x_mm,marker_y_mm\n" + twice("{0},{1},{2},{3},{2}\n"));
  TrackReading how;
  EXPECT_TRUE(read_any_track(in_folder("x.csv"), how).table.platform_frame) << "by its mark";
  how.frame = "camera";
  EXPECT_FALSE(read_any_track(in_folder("x.csv"), how).table.platform_frame);
  how.frame = "platform";
  const Track track = read_any_track(in_folder("x.csv"), how);
  EXPECT_TRUE(track.table.platform_frame && !track.in_camera_frame && track.table.marker.empty());
  EXPECT_NEAR(1e3 * track.table.position.back().x(), 0.05 * (kRows - 1), 1e-9) << "nothing taken out";
  import_track(in_folder("x.csv"), how, in_folder("t.csv"));
  EXPECT_TRUE(read_track_file(in_folder("t.csv")).table.platform_frame) << "and read back";
  how.mark = "marker";
  EXPECT_THAT(complaint_of([&] { read_any_track(in_folder("x.csv"), how); }), HasSubstr("give one of them"));
}

}  // namespace
}  // namespace tribotrack::apps
