#include "apps/report/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "apps/chromium.h"
#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using test::occurrences;
using testing::HasSubstr;
using testing::Not;

std::string parameters_of(const ReportData& data) {
  return parameter_section(data, {}).html;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(FirstScreen, ValuesAsDescribedStandBesideThoseQuoted) {
  ReportData data = sample::campaign();
  EXPECT_THAT(first_screen(data, {}), Not(HasSubstr("as described")));
  data.fit.as_assumed[fit::FitParameter::mu1] = {0.12, 0.001, {0.118, 0.122}};
  const std::string html = first_screen(data, {});
  EXPECT_THAT(html, HasSubstr("<th>as described, rejected</th>"));
  EXPECT_THAT(html, HasSubstr("<td>0.1200(10)<br><span class=\"ends\">0.1180 to 0.1220</span></td></tr>"));
}

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

TEST(ParameterSection, ABootstrapHasItsColumnAndItsSeed) {
  ReportData data = sample::campaign();
  for (fit::ParameterEstimate& p : data.fit.parameters) p.bootstrap_ci95 = p.ci95;
  data.fit.bootstrap = {400, 7};
  const std::string html = parameters_of(data);
  EXPECT_THAT(html, HasSubstr("<th class=\"n\">by profile</th><th class=\"n\">by bootstrap</th>"));
  EXPECT_THAT(html, HasSubstr("95 % of 400 refits to simulated data (seed 7)"));
}

TEST(ParameterSection, WhatTheDataLeaveOpenComesWithItsRemedy) {
  ReportData data = sample::campaign();
  data.fit.identifiability = {
      fit::Verdict::not_identifiable, {"mu1 up 1 % is hidden by phase_lag_rad down 0.021."}, {}};
  data.fit.next_experiment.reset();
  data.fit.other_next_experiments.resize(1);
  data.fit.other_next_experiments[0].sentence = "For mu1 film dtau = 3.";
  data.fit.minima = {{}, {{}, 1.2, "Another minimum: mu1 = 0.154."}};
  data.shared_scale = "14 recordings share one scale";
  const std::string html = parameters_of(data);
  EXPECT_THAT(html, HasSubstr("<li>μ₁ up 1 % is hidden by lag down 0.021.</li>"));
  EXPECT_THAT(html, HasSubstr("<b>Remedy:</b> For μ₁ film Δτ = 3."));
  EXPECT_THAT(html, HasSubstr("<h3>Other minima</h3>"));
  EXPECT_THAT(html, HasSubstr("<p>14 recordings share one scale.</p>"));
  for (const char* absent : {"bootstrap", "taken as known is wrong", "nan"})
    EXPECT_THAT(html, Not(HasSubstr(absent)));
  data.fit.minima.resize(6, {{}, 1.2, "Another minimum: mu1 = 0.2."});
  EXPECT_EQ(occurrences(parameters_of(data), "<li>Another minimum"), 3u);
  data.fit.dof = 0;
  EXPECT_EQ(occurrences(parameters_of(data), "Another minimum"), 0u);
}

TEST(ParameterSection, IsLeftOutWithoutAFit) {
  EXPECT_EQ(parameters_of(ReportData{}), "");
}

}  // namespace

namespace {

using sample::pi;
using testing::HasSubstr;

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

}  // namespace

}  // namespace tribotrack::apps
