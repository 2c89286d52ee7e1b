#include "apps/report/page/parameters/next.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/chromium.h"
#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using sample::pi;
using test::occurrences;
using testing::HasSubstr;

ReportNextRun run(double amplitude_mm, const std::string& aim) {
  return {.phi_rad = 1.5 * pi,
          .dtau_rad = pi,
          .amplitude_mm = amplitude_mm,
          .w_rad_s = 62.8,
          .aim = aim,
          .predicted_ci95 = {{0.0997, 0.1003}, {0.0121, 0.0131}, {-INFINITY, INFINITY}},
          .sentence = "Film next."};
}

TEST(NextSection, TheIntervalsPredictedStandUnderThoseOfNow) {
  ReportData data = sample::campaign();
  data.next_runs = {run(0.28, "")};
  const std::string html = next_section(data).html;
  EXPECT_THAT(html, HasSubstr("A run at φ = 3π/4"));
  const std::size_t now = html.find("0.09952 to 0.10073");
  const std::size_t then = html.find(
      "<td><b>all together</b></td><td class=\"n\">3π/2</td><td class=\"n\">π</td><td "
      "class=\"n\">0.28</td><td class=\"n\">62.8</td><td class=\"n\">0.09970 to 0.10030</td><td "
      "class=\"n\">0.01210 to 0.01310</td><td class=\"n\">−∞ to ∞</td>");
  ASSERT_NE(now, std::string::npos);
  ASSERT_NE(then, std::string::npos) << html;
  EXPECT_LT(now, then);
}

TEST(NextSection, ARunBestForTwoParametersStandsOnce) {
  ReportData data = sample::campaign();
  data.next_runs = {run(0.28, ""), run(0.35, "mu1"), run(0.35, "phase_lag_rad")};
  const std::string html = next_section(data).html;
  EXPECT_THAT(html, HasSubstr("<b>μ<sub>1</sub> alone, lag alone</b>"));
  EXPECT_EQ(occurrences(html, "<tr>"), 4u);  // heading, now, two runs
}

TEST(NextSection, IsLeftOutWhereNoneWasLookedFor) {
  ReportData data = sample::campaign();
  data.next_experiment.clear();
  EXPECT_EQ(next_section(data).html, "");
}

}  // namespace
}  // namespace tribotrack::apps
