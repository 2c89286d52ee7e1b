// The page of `run` and of a later `report`: the same bytes, the same numbers in drawings and text.
#include "apps/report/report.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "apps/files/track_file.h"
#include "apps/program.h"
#include "apps/report/data/collect.h"

namespace tribotrack::apps {
namespace {

/// Two recordings with marker and lamp, scaled by the part's diameter and so by one scale, a run measured
/// elsewhere and one whose recording is missing.
class ReportOfARun : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    put(in_folder("scene.toml"), R"(
[platform]
amplitude_mm = 0.28
angular_frequency_rad_s = 62.8
[friction]
mu1 = 0.1
mu1_over_mu2 = 8
lag_rad = 0.2
[run]
cycles = 8
[video]
width = 200
height = 200
frame_rate_hz = 250
exposure_s = 4e-3
[camera]
mm_per_px = 0.1
read_noise = 2
[disc]
diameter_mm = 3.6
[surface]
level = 70
texture_rms = 0
[marker]
position_px = [24, 24]
radius_px = 12
[lamp]
position_px = [176, 24]
radius_px = 7
[[shot]]
name = "a"
phi_rad = 0.5
dtau_rad = "pi/3"
[[shot]]
name = "b"
phi_rad = 2.5
dtau_rad = "pi/3"
seed = 2
)");
    ASSERT_EQ(run("synth scene.toml -o recordings -q").exit_code, 0);
    put(in_folder("disc.toml"), R"(
[platform]
phase_shift_rad = "pi/2"
amplitude_mm = 0.28
angular_frequency_rad_s = 62.8
[part]
diameter_mm = 3.6
[camera]
marker_px = [24, 24, 12]
gate_px = [176, 24, 6]
[fit]
parameters = ["mu1", "phase_lag_rad"]
cycles = 8
[fit.fixed]
mu2 = 0.0125
[[run]]
video = "recordings/a.cine"
phi_rad = 0.5
dtau_rad = "pi/3"
[[run]]
video = "recordings/b.cine"
phi_rad = 2.5
dtau_rad = "pi/3"
[[run]]
name = "elsewhere"
phi_rad = 4
dtau_rad = "pi/3"
alpha_rad = 1.5
alpha_sd_rad = 0.5
v_mm_s = 3.9
v_sd_mm_s = 0.5
[[run]]
video = "recordings/gone.cine"
phi_rad = 1
dtau_rad = "pi/3"
)");
    ASSERT_EQ(run("run disc.toml -q -o out").exit_code, 4) << "one recording is missing";
  }

  RunFolder folder() const { return {in_folder("out")}; }
};

TEST_F(ReportOfARun, ALaterReportIsTheSamePage) {
  const std::string page = content_of(folder().report());
  ASSERT_EQ(run("report out -o later.html -q").exit_code, 0);
  EXPECT_TRUE(page == content_of(in_folder("later.html"))) << "not the same bytes";
  EXPECT_TRUE(page.find("<h1>disc</h1>") != std::string::npos) << "the campaign's name is the title";
  EXPECT_TRUE(page.find("there is no recording") != std::string::npos);

  // The drawings show what was measured once, at the scale that all recordings share.
  const ReportData data = collect(folder());
  for (const std::string name : {"a", "b"}) {
    const ReportRun& seen = data.runs[name == "a" ? 0 : 1];
    const Track track = read_track_file(folder().track(name));
    const Json measured = read_json(folder().measurement(name));
    const double used = measured["mm_per_px"], own = *track.mm_per_px;
    EXPECT_NE(used, own) << "the scale was not shared: this test shows nothing";
    ASSERT_EQ(seen.track.x_mm.size(), track.x_mm.size());
    EXPECT_DOUBLE_EQ(seen.track.x_mm.back(), track.x_mm.back() * used / own);
    const double half = 0.5 * seen.value("angular_frequency_rad_s").value * track.table.exposure;
    double reach = 0;
    for (const Eigen::Vector2d& point : seen.platform.model) reach = std::max(reach, 1e3 * point.x());
    EXPECT_NEAR(reach, seen.value("amplitude_mm").value * std::sin(half) / half, 1e-12);
  }
}

}  // namespace
}  // namespace tribotrack::apps
