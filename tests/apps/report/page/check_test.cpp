#include "apps/report/tables/tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string check_of(const ReportData& data) {
  return check_section(data, {}).html;
}

TEST(CheckSection, ChiSquareIsReadAgainstWhatChanceAllows) {
  ReportData data = sample::campaign();
  data.fit.p_value = 0.0689;
  const std::string html = check_of(data);
  EXPECT_THAT(html, HasSubstr(" of 100 campaigns. The model would be rejected below p = 0.001; it is not."));
  EXPECT_THAT(html, HasSubstr("χ² = 26.4 with 27 degrees of freedom: 0.978 per degree of freedom"));
  EXPECT_THAT(html,
              HasSubstr("<b>p = 0.069</b>: chance alone would make χ² so large in 6.9 of 100 campaigns."));
  data.fit.p_value = 0;
  data.fit.scatter = 5e-4;
  EXPECT_THAT(
      check_of(data),
      HasSubstr(
          "<b>p &lt; 1e-300</b>: without the scatter estimated from the residuals, chance alone would make "
          "χ² so large in fewer than one of 1000 campaigns."));
}

TEST(CheckSection, OutlyingRunsAreNamedWithWhatTheyLookLike) {
  ReportData data = sample::campaign();
  data.fit.outliers = {{"phi90_dtau60", 12.3, 3e-8, sample::pi, ""}, {"elsewhere", 5.0, 0, {}, ""}};
  const std::string html = check_of(data);
  EXPECT_THAT(html,
              HasSubstr("<td><b>phi90_dtau60</b></td><td class=\"n\">12 σ</td><td class=\"n\">3e-08</td>"
                        "<td class=\"n\">π/2</td><td class=\"n\">π</td>"));
  EXPECT_THAT(html,
              HasSubstr("<td><b>elsewhere</b></td><td class=\"n\">5 σ</td><td class=\"n\">&lt; 1e-300</td>"
                        "<td class=\"n\">–</td><td class=\"n\">–</td>"));
  data.fit.outliers[0].looks_like_phi.reset();
  EXPECT_THAT(check_of(data), Not(HasSubstr("that would fit")));
}

TEST(CheckSection, ExplanationsStandBesideWhatWasAssumed) {
  ReportData data = sample::campaign();
  const fit::FitParameter mu1 = data.fit.parameters.front().parameter;
  data.fit.as_assumed[mu1] = {0.1, 0.001, {0.098, 0.102}};
  fit::Explanation& tilt = data.fit.explanations.emplace_back();
  tilt.name = "tilt";
  tilt.chi2_fall = 120;
  tilt.p_after = 0.3;
  tilt.size = 1e-3;
  tilt.size_sd = 1e-4;
  tilt.unit = "rad";
  tilt.refitted = tilt.explains = true;
  tilt.parameters[mu1] = {0.103, 0.001, {0.101, 0.105}};
  data.fit.explanations.push_back(tilt);
  data.fit.explanations.back().run = "<a>";
  data.fit.left_out = {"Something was not needed."};
  const std::string html = check_of(data);
  EXPECT_THAT(html, HasSubstr("<td><b>nothing</b></td>"));
  EXPECT_THAT(html, HasSubstr("<td class=\"n\">0.1000(10)</td>"));
  EXPECT_THAT(html, HasSubstr("<td>tilt</td><td class=\"n\">120</td><td class=\"n\">0.3</td>"
                              "<td class=\"n\">0.00100(10) rad</td><td class=\"n\">0.1030(10)</td>"));
  EXPECT_THAT(html, HasSubstr("tilt &lt;a&gt;"));
  EXPECT_THAT(html, HasSubstr("<li>Something was not needed.</li>"));
}

}  // namespace
}  // namespace tribotrack::apps
