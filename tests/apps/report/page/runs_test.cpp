#include "apps/report/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

ReportData one_run() {
  ReportData data;
  ReportRun run;
  run.name = "a";
  run.video = "a.cine";
  run.phi_rad = sample::pi / 2;
  run.dtau_rad = sample::pi / 3;
  run.measured = {{"alpha_rad", {1.2345, 0.012}}, {"v_mm_s", {2.5, 0.05}}};
  run.fitted.residuals = {{"alpha_rad", 1.2345, 1.23, 0.012, 0}, {"v_mm_s", 2.5, 2.51, 0.05, 0}};
  run.cycles = 20;
  run.track.frames = 11;
  run.track.lost = 2;
  run.track.edge = 1;
  run.track.repeats = 1;
  run.track.frame_rate_hz = 1000;
  run.track.time_base = "camera header";
  run.sigma_px = 0.0123;
  data.runs = {run};
  return data;
}

TEST(RunSection, RemarksOfOneCauseAreOneLine) {
  ReportData data = one_run();
  data.runs.push_back(data.runs[0]);
  data.runs[1].name = "b";
  data.runs[0].notes = {"a gap after frame 12", "no marker"};
  data.runs[1].notes = {"a gap after frame 370"};
  EXPECT_THAT(run_section(data).html,
              HasSubstr("<ul><li>all 2 runs: a gap after frame 12 (in a; in the others "
                        "likewise)</li><li>a: no marker</li></ul>"));
}

TEST(PictureSection, ThePathIsDrawnOverThePictureWithGaps) {
  ReportData data = one_run();
  ReportRun& run = data.runs[0];
  run.first_frame = sample::kPng;
  run.track.width_px = 64;
  run.track.height_px = 48;
  run.track.x_px = {no_value, 10, 11, no_value, 13, no_value};
  run.track.y_px = {no_value, 20, 21, no_value, 23, no_value};
  const std::string html = picture_section(data).html;
  EXPECT_THAT(html, HasSubstr("viewBox=\"0 0 64 48\""));
  // Pixel centres are at whole numbers: the picture's corner is (-0.5, -0.5).
  EXPECT_THAT(html, HasSubstr("class=\"path\" d=\"M10.5 20.5L11.5 21.5M13.5 23.5\""));
  EXPECT_THAT(html, HasSubstr("class=\"start\" cx=\"10.5\" cy=\"20.5\""));
  EXPECT_THAT(html, HasSubstr("data:image/png;base64,iVBORw0KGgo"));
  EXPECT_THAT(html, HasSubstr("φ = π/2, Δτ = π/3"));
}

TEST(PlanSection, RunsWithTheSamePlanShareATable) {
  ReportData data = one_run();
  data.runs[0].track.plan = {{"rotation", false, "turns by 0.1°", {}}};
  data.runs.resize(3, data.runs[0]);
  data.runs[1].track.plan[0].on = true;
  data.runs[2].track.plan[0].reason = "turns by 0.2°";  // other figures, the same plan
  const std::string html = plan_section(data).html;
  EXPECT_THAT(html, HasSubstr("<summary>runs 1, 3: 1 of 1 stages left out</summary>"));
  EXPECT_THAT(html, HasSubstr("<summary>2 a: 0 of 1 stages left out</summary>"));
}

}  // namespace
}  // namespace tribotrack::apps
