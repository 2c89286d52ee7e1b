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

TEST(RunSection, ARowSaysAllThatWasMeasured) {
  EXPECT_THAT(
      run_section(one_run()).html,
      HasSubstr(
          "<td class=\"n\">1</td><td><b>a</b></td><td class=\"n\" data-v=\"1.5707963267948966\">π/2</td><td "
          "class=\"n\" data-v=\"1.0471975511965976\">π/3</td><td class=\"n\" data-v=\"1.2345\" "
          "data-sd=\"0.012\">1.234(12)</td><td class=\"n\">1.230</td><td class=\"n\" data-v=\"2.5\" "
          "data-sd=\"0.05\">2.500(50)</td>"
          "<td class=\"n\">2.510</td><td class=\"n\">20</td><td class=\"n\">7 / 2 / 1 / 1</td>"
          "<td class=\"n\">0.012</td><td>1000 Hz, camera header</td></tr>"));
}

TEST(RunSection, AFailedRunSaysWhy) {
  ReportData data = one_run();
  data.runs[0].failure = "a.cine is empty.";
  EXPECT_THAT(run_section(data).html, HasSubstr("failed: a.cine is empty.</td></tr>"));
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

TEST(PictureSection, JpegIsToldFromPng) {
  ReportData data = one_run();
  data.runs[0].first_frame = {0xff, 0xd8, 0xff};
  data.runs[0].track.width_px = data.runs[0].track.height_px = 10;
  EXPECT_THAT(picture_section(data).html, HasSubstr("data:image/jpeg;base64,/9j/"));
}

TEST(PlanSection, StagesLeftOutComeWithTheirReasonAndError) {
  ReportData data = one_run();
  data.runs[0].track.plan = {{"rotation", false, "turns by 0.1°", 0.002},
                             {"weights", false, "even light", 0},
                             {"illumination", false, "brushed platform", {}},
                             {"marker", true, "moves", {}}};
  const std::string html = plan_section(data).html;
  EXPECT_THAT(html, HasSubstr("1 a: 3 of 4 stages left out"));
  EXPECT_THAT(html, HasSubstr("<td>rotation</td><td><b>left out</b></td><td>turns by 0.1°</td>"
                              "<td>0.002 px</td>"));
  EXPECT_THAT(html, HasSubstr("<td>even light</td><td>none</td>"));
  EXPECT_THAT(html, HasSubstr("<td>brushed platform</td><td>not known</td>"));
  EXPECT_EQ(plan_section(one_run()).html, "");
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

TEST(AuditSection, ARowOfRatiosForEachRunThatHasAny) {
  ReportData data = one_run();
  EXPECT_EQ(audit_section(data).html, "");  // a track of an earlier version, or a run measured elsewhere
  data.runs[0].track.audit.halves_x = 1.42;
  data.runs[0].track.audit.high_frequency = 1.31;
  data.runs[0].track.audit.white_factor = 4;
  data.runs[0].track.audit.slow_sd = 0.0123;
  EXPECT_THAT(audit_section(data).html,
              HasSubstr("<b>a</b></td><td class=\"n\">1.42</td><td class=\"n\">–</td><td "
                        "class=\"n\">1.31</td><td "
                        "class=\"n\">2.00</td><td "
                        "class=\"n\">0.0123</td></tr>"));
}

}  // namespace
}  // namespace tribotrack::apps
