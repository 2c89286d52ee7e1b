#include "apps/report/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "apps/program.h"
#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

TEST(ParameterSection, OpenAndMissingIntervalsAreSaid) {
  ReportData data = sample::campaign();
  data.fit.parameters[0].ci95 = {0.05, std::numeric_limits<double>::infinity()};
  data.fit.parameters[0].profile_ci95 = {no_value, no_value};
  EXPECT_THAT(parameter_section(data, {}).html,
              HasSubstr("<td class=\"n ends\">0.05000 to ∞</td><td class=\"n ends\">0.09952 to 0.10073</td>"
                        "<td class=\"n ends\">–</td><td>1</td>"));
}

TEST(PictureSection, ThePathIsDrawnOverThePictureWithGaps) {
  ReportData data;
  ReportRun& run = data.runs.emplace_back();
  run.name = "a";
  run.video = "a.cine";
  run.phi_rad = sample::pi / 2;
  run.dtau_rad = sample::pi / 3;
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

}  // namespace

}  // namespace tribotrack::apps
