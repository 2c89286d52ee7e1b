#include "apps/files/campaign/data_section.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "apps/files/campaign/campaign.h"
#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double pi = std::numbers::pi;

class Tables : public ProgramTest {
 protected:
  Campaign read(const std::string& table, const std::string& data = "", const std::string& rest = "") {
    put(in_folder("alpha_v.csv"), table);
    put(in_folder("c.toml"),
        "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = \"pi/2\"\n"
        "[data]\ntable = \"alpha_v.csv\"\n" +
            data + rest);
    return read_campaign(in_folder("c.toml"));
  }
  std::string complaint(const std::string& table, const std::string& data = "",
                        const std::string& rest = "") {
    const std::string message = complaint_of([&] { read(table, data, rest); });
    const std::string folder = in_folder("").string();
    return message.substr(message.starts_with(folder) ? folder.size() : 0);
  }
};

constexpr const char* kTable =
    "phi_rad,dtau_rad,alpha_rad,alpha_sd_rad,v_mm_s,v_sd_mm_s\n"
    "0,1.047,5.6,0.02,3.93,0.04\n"
    "1.5,1.047,4.1,0.02,4.02,0.04\n"
    "0,2.094,5.3,0.02,8.19,0.05\n";

TEST_F(Tables, EachLineIsARun) {
  const Campaign c = read(kTable);
  ASSERT_EQ(c.runs.size(), 3u);
  EXPECT_EQ(c.runs[1].name, "alpha_v:3");
  EXPECT_THAT(c.runs[1].place, HasSubstr("alpha_v.csv:3"));
  EXPECT_EQ(c.runs[1].phi, 1.5);
  EXPECT_EQ(*c.runs[1].alpha, 4.1);
  EXPECT_EQ(*c.runs[2].v, 8.19e-3);
  EXPECT_EQ(*c.runs[2].v_sd, 0.05e-3);
  EXPECT_EQ(c.runs[0].cycles, 20);
  EXPECT_THAT(c.notes, IsEmpty());
  EXPECT_EQ(c.table_inputs.size(), 1u);
  const auto files = c.input_files();
  EXPECT_EQ(std::count(files.begin(), files.end(), in_folder("alpha_v.csv")), 1);
}

TEST_F(Tables, ConditionsMayBeColumns) {
  const Campaign c = read(
      "name,phi_rad,dtau_rad,alpha_rad,alpha_sd_rad,v_mm_s,v_sd_mm_s,amplitude_mm,amplitude_sd_mm,f "
      "(Hz),cycles,"
      "start_phase_rad,remark\n"
      "a,0,1,5.6,0.02,3.93,0.04,0.28,0.001,10,12,0.5,quiet\n"
      "b,0,1,5.6,0.02,3.93,0.04,0.14,,,,,\n");
  EXPECT_EQ(c.runs[0].name, "a");
  EXPECT_DOUBLE_EQ(*c.runs[0].amplitude, 0.28e-3);
  EXPECT_DOUBLE_EQ(*c.runs[0].amplitude_sd, 1e-6);
  EXPECT_DOUBLE_EQ(*c.runs[0].angular_frequency, 20 * pi);
  EXPECT_EQ(c.runs[0].cycles, 12);
  EXPECT_EQ(*c.runs[0].start_phase, 0.5);
  EXPECT_FALSE(c.runs[1].angular_frequency);
  EXPECT_EQ(c.runs[1].cycles, 20);
  EXPECT_THAT(c.notes, ElementsAre(HasSubstr("not used: remark")));
}

TEST_F(Tables, RepeatsOfAPointArePooled) {
  const Campaign c = read(
      "phi_rad,dtau_rad,alpha_rad,alpha_sd_rad,v_mm_s,v_sd_mm_s\n"
      "0,1,6.2,0.04,4.0,0.08\n"
      "3,1,3,0.04,4.0,0.08\n"
      "2pi,1,6.22,0.04,4.1,0.08\n"  // one turn more is the same phi
      "0,1,0.01,0.04,3.9,0.08\n");
  ASSERT_EQ(c.runs.size(), 2u);
  EXPECT_EQ(c.runs[0].name, "alpha_v:2");
  EXPECT_EQ(c.runs[0].pooled_from.size(), 3u);
  EXPECT_NEAR(*c.runs[0].alpha, (6.2 + 6.22 + 2 * pi + 0.01) / 3, 2e-3);
  EXPECT_NEAR(*c.runs[0].v_sd, 0.08e-3 / std::sqrt(3.0), 1e-12);
  EXPECT_THAT(c.notes, ElementsAre(HasSubstr("4 lines of tables are 2 points")));
}

TEST_F(Tables, WithoutSdsTheRepeatsTell) {
  const Campaign c =
      read("phi_rad,dtau_rad,alpha_rad,v_mm_s\n0,1,6.2,4.0\n0,1,6.1,4.2\n3,1,3,4.0\n3,1,3.2,4.1\n1,1,5,4\n");
  ASSERT_EQ(c.runs.size(), 3u);
  // s of alpha: sqrt((0.1^2 + 0.2^2)/2/2) = 0.112 to second order; t of 2 degrees of freedom.
  EXPECT_NEAR(*c.runs[2].alpha_sd, 0.1118 * 4.3027 / 1.95996, 8e-3);
  EXPECT_NEAR(*c.runs[0].alpha_sd, *c.runs[2].alpha_sd / std::sqrt(2.0), 5e-3);
  EXPECT_THAT(c.notes, ::testing::Contains(HasSubstr("2 degrees of freedom")));
}

TEST_F(Tables, TheSdOfAllLinesMayBeGivenOnce) {
  const Campaign c = read("phi_rad,dtau_rad,alpha_rad,v_mm_s\n0,1,6.2,4.0\n3,1,3,4.0\n",
                          "alpha_sd_rad = \"2deg\"\nv_sd_mm_s = 0.1\n");
  EXPECT_DOUBLE_EQ(*c.runs[1].alpha_sd, 2 * pi / 180);
  EXPECT_DOUBLE_EQ(*c.runs[1].v_sd, 1e-4);
  EXPECT_THAT(
      complaint("phi_rad,dtau_rad,alpha_rad,v_mm_s\n0,1,6.2,4.0\n3,1,3,4.0\n"),
      HasSubstr("alpha_v.csv:2: nothing says how good its alpha and v are: it has no sd and no point of the "
                "table is measured twice; fill in alpha_sd_deg and v_sd_mm_s, or give the sd of all lines "
                "once, [data] alpha_sd_rad = \"2deg\", v_sd_mm_s = 0.1"));
}

TEST_F(Tables, SeveralTablesAndRunsBesideThem) {
  put(in_folder("more.csv"), "phi_rad,dtau_rad,alpha_rad,alpha_sd_rad,v_mm_s,v_sd_mm_s\n2,1,4,0.02,4,0.04\n");
  put(in_folder("alpha_v.csv"), kTable);
  put(in_folder("c.toml"),
      "[data]\ntable = [\"alpha_v.csv\", \"more.csv\"]\n[[run]]\nname = \"own\"\nphi_rad = 0\ndtau_rad = "
      "1\nalpha_rad "
      "= 5\nalpha_sd_rad = 0.1\nv_mm_s = 2\nv_sd_mm_s = 0.1\n");
  const Campaign c = read_campaign(in_folder("c.toml"));
  ASSERT_EQ(c.runs.size(), 5u);
  EXPECT_EQ(c.runs[0].name, "own");
  EXPECT_EQ(c.runs[4].name, "more:2");
}

TEST_F(Tables, WhatIsWrongIsNamedWithPlaceAndRemedy) {
  EXPECT_THAT(complaint("phi_mm,dtau_rad,alpha_rad,v_mm_s\n"),
              HasSubstr("has no column phi_rad (is it `phi_mm`?)"));
  EXPECT_THAT(complaint("phi_rad,dtau_rad,aplha_rad,v_mm_s\n0,1,2,3\n"),
              HasSubstr("alpha_v.csv:1: has no column alpha_rad (is it `aplha_rad`?)"));
  EXPECT_THAT(complaint("phi_rad,phi_deg,dtau_rad,alpha_rad,v_mm_s\n"), HasSubstr("is there twice"));
  const std::string header = "phi_rad,dtau_rad,alpha_rad,v_mm_s,v_sd_mm_s\n";
  EXPECT_THAT(complaint(header + "0,1,,3,1\n"), HasSubstr("alpha_v.csv:2: a run needs"));
  EXPECT_THAT(complaint(header + "0,7,2,3,1\n"), HasSubstr("alpha_v.csv:2: `dtau_rad` must lie between 0"));
  EXPECT_THAT(complaint(header + "0,1,2,-3,1\n"), HasSubstr("alpha_v.csv:2: `v_mm_s` must be 0 or more"));
  EXPECT_THAT(complaint(header + "0,1,2,3,0\n"), HasSubstr("`v_sd_mm_s` must be greater than 0"));
  EXPECT_THAT(complaint(header + "0,1,2,3,1,4\n"), HasSubstr("6 cells under 5 columns; is a decimal comma"));
  EXPECT_THAT(complaint(header), HasSubstr("no line of numbers"));
  EXPECT_THAT(complaint(""), HasSubstr("is empty"));
  EXPECT_THAT(complaint("PK\x03\x04"), HasSubstr("save it as CSV"));
  put(in_folder("c.toml"), "[data]\nv_sd_mm_s = 1\n[[run]]\n");
  EXPECT_THAT(complaint_of([&] { read_campaign(in_folder("c.toml")); }), HasSubstr("needs `table`"));
}

TEST_F(Tables, RepeatsThatScatterMoreThanTheirSdsAreAWarning) {
  std::string table = "phi_rad,dtau_rad,alpha_rad,alpha_sd_rad,v_mm_s,v_sd_mm_s\n";
  for (const char* v : {"4.0", "4.6", "3.8", "4.9"}) table += std::string("0,1,6.2,0.01,") + v + ",0.05\n";
  const Campaign c = read(table);
  EXPECT_THAT(c.warnings, ElementsAre(HasSubstr("times as much as their sds say")));
  EXPECT_GT(*c.runs[0].v_sd, 0.1e-3);
}

TEST_F(Tables, ARunHasOneSourceOfItsMotion) {
  const auto run = [&](const std::string& keys) {
    put(in_folder("c.toml"), "[[run]]\nphi_rad = 0\ndtau_rad = 1\n" + keys);
    return complaint_of([&] { read_campaign(in_folder("c.toml")); });
  };
  EXPECT_THAT(run("track = \"x.csv\"\nvideo = \"x.avi\"\n"),
              HasSubstr("c.toml:4:1: `track` in [[run]] and `video` are two sources of one motion"));
  EXPECT_THAT(run("track = \"x.csv\"\ndisc_px = [1, 2, 3]\n"), HasSubstr("this run's `track` is finished"));
  EXPECT_THAT(run("track_unit = \"mm\"\nvideo = \"x.avi\"\n"), HasSubstr("needs `track`"));
  EXPECT_THAT(run("track = \"x.csv\"\nalpha_rad = 1\n"), HasSubstr("not both"));
  EXPECT_THAT(run("track = \"x.csv\"\ntrack_unit = \"inch\"\n"),
              HasSubstr("must be one of px, um, mm, cm, m, not \"inch\""));
  EXPECT_THAT(run("track = \"x.csv\"\n"), "no complaint");
}

TEST_F(Tables, AListOfRunsGivesTheirKeys) {
  const auto listed = [&](const std::string& table) {
    put(in_folder("runs.csv"), table);
    put(in_folder("c.toml"),
        "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\n[part]\ndiameter_mm = 6\n"
        "[data]\nruns = \"runs.csv\"\n[[run]]\nvideo = \"a.cine\"\nphi_rad = 0\ndtau_rad = \"60deg\"\n");
    return read_campaign(in_folder("c.toml"));
  };
  const Campaign c = listed(
      "# the camera's files\nvideo;phi (\xc2\xb0);dtau_rad;name;f (Hz);A in um;by\n"
      "b.cine;22,5;pi/3;second;10;;me\nc.cine;45;1,5;;10;280,5;me\n");
  ASSERT_EQ(c.runs.size(), 3u);
  EXPECT_EQ(c.runs[1].video, in_folder("b.cine"));
  EXPECT_EQ(c.runs[1].name, "second");
  EXPECT_DOUBLE_EQ(c.runs[1].phi, pi / 8);
  EXPECT_DOUBLE_EQ(c.runs[1].dtau, pi / 3);
  EXPECT_EQ(c.runs[2].name, "c");
  EXPECT_DOUBLE_EQ(c.runs[2].dtau, 1.5);
  EXPECT_THAT(c.notes, ElementsAre(HasSubstr("runs.csv: not used: A in um, by")));
  EXPECT_THAT(c.runs[2].place, HasSubstr("runs.csv:4"));
  const Campaign d = listed("video,phi_deg,dtau_deg,amplitude_um,frequency_hz\nb.cine,90,60,250,10\n");
  EXPECT_DOUBLE_EQ(*d.runs[1].amplitude, 250e-6);
  EXPECT_DOUBLE_EQ(*d.runs[1].angular_frequency, 20 * pi);
  const Campaign e = listed("File;phi;dtau\nb.cine;22,5\u00b0;0,5 rad\n");  // units in the cells
  EXPECT_DOUBLE_EQ(e.runs[1].phi, pi / 8);
  EXPECT_DOUBLE_EQ(e.runs[1].dtau, 0.5);
  EXPECT_THAT(complaint_of([&] { listed("video,phi,dtau_deg\nb.cine,90,60\n"); }),
              HasSubstr("runs.csv:2:8: `90` has no unit"));
  EXPECT_THAT(complaint_of([&] { listed("video,phi_deg\nb.cine,90\n"); }),
              HasSubstr("runs.csv:2: a run needs `phi_rad` and"));
  EXPECT_THAT(complaint_of([&] { listed("what,when\nb.cine,9\n"); }),
              HasSubstr("no line names its columns: it holds"));
}

}  // namespace
}  // namespace tribotrack::apps
