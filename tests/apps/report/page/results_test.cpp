#include "apps/report/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "apps/program.h"
#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using test::occurrences;
using testing::HasSubstr;

std::string parameters_of(const ReportData& data) {
  return parameter_section(data, {}).html;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(FirstScreen, SaysWhatTheValuesAssumeAndWhatToDoNext) {
  ReportData data = sample::campaign();
  data.exact = {"gravity_m_s2"};
  data.fit.improve_first = "Improve first: scale.";
  const auto source = [&](const char* name, double share) {
    fit::BudgetEntry& entry = data.fit.budget.emplace_back();
    entry.source = name;
    entry.from = "diameter_mm, default sd";
    entry.contribution = Eigen::VectorXd::Constant(3, share * data.fit.parameters[0].sd);
  };
  source("felt", 0.2);
  source("not felt", 0.05);
  const std::string html = first_screen(data, {});
  EXPECT_THAT(html, HasSubstr("<li>Taken as exact: g.</li>"));
  EXPECT_THAT(html, HasSubstr("because none was given: felt.</li>"));
  EXPECT_THAT(html, HasSubstr("<h2>Next</h2>\n<ul><li>Improve first: scale.</li><li>"));
  data.fit.verdict = fit::Use::do_not_use;
  EXPECT_THAT(first_screen(data, {}), HasSubstr("<ul><li>Find out what is wrong: "));
}

TEST(ParameterSection, OpenAndMissingIntervalsAreSaid) {
  ReportData data = sample::campaign();
  data.fit.parameters[0].ci95 = {0.05, infinity};
  data.fit.parameters[0].profile_ci95 = {no_value, no_value};
  EXPECT_THAT(parameters_of(data),
              HasSubstr("<td class=\"n ends\">0.05000 to ∞</td><td class=\"n ends\">0.09952 to 0.10073</td>"
                        "<td class=\"n ends\">–</td><td>1</td>"));
}

using sample::pi;

fit::NextExperiment run(double amplitude, std::optional<fit::FitParameter> aim = {}) {
  return {.phi = 1.5 * pi,
          .dtau = pi,
          .amplitude = amplitude,
          .angular_frequency = 62.8,
          .aim = aim,
          .predicted_sd = {},
          .predicted_ci95 = {{fit::FitParameter::mu1, {0.0997, 0.1003}},
                             {fit::FitParameter::mu2, {0.0121, 0.0131}},
                             {fit::FitParameter::lag, {-INFINITY, INFINITY}}},
          .sentence = "Film next: a run."};
}

TEST(NextSection, TheIntervalsPredictedStandUnderThoseOfNow) {
  ReportData data = sample::campaign();
  data.fit.next_experiment = run(0.28e-3);
  const std::string html = next_section(data).html;
  EXPECT_THAT(html, HasSubstr("<p>Film next: a run.</p>"));
  const std::size_t now = html.find("0.09952 to 0.10073");
  const std::size_t then = html.find(
      "<td><b>all together</b></td><td class=\"n\">3π/2</td><td class=\"n\">π</td><td "
      "class=\"n\">0.28</td><td class=\"n\">62.8</td><td class=\"n\">0.09970 to 0.10030</td><td "
      "class=\"n\">0.01210 to 0.01310</td><td class=\"n\">−∞ to ∞</td>");
  ASSERT_NE(now, std::string::npos);
  ASSERT_NE(then, std::string::npos) << html;
  EXPECT_LT(now, then);
}

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

}  // namespace

}  // namespace tribotrack::apps
