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

TEST(CheckSection, WithoutSpareDataNothingChecksTheModel) {
  ReportData data = sample::campaign();
  data.fit.dof = 0;
  data.fit.p_value = 1;
  EXPECT_THAT(check_of(data), HasSubstr("with 0 degrees of freedom: as many data as unknowns"));
  EXPECT_THAT(check_of(data), Not(HasSubstr("p = ")));
}

TEST(CheckSection, TheRunsTestSaysWhatItMeans) {
  ReportData data = sample::campaign();
  data.fit.runs_test_p_value = 0.4;
  EXPECT_THAT(check_of(data), HasSubstr("<b>Runs test: p = 0.4</b> (threshold 0.01): no sign"));
  EXPECT_THAT(check_of(data), Not(HasSubstr("fewer than eight")));
  data.fit.runs_test_p_value = 1;
  EXPECT_THAT(check_of(data), HasSubstr("<b>Runs test: p = 1</b> (threshold 0.01): residuals of neighbouring "
                                        "runs change sign as often as by chance"));
  ReportData few = data;
  few.runs.resize(7);
  EXPECT_THAT(check_of(few), HasSubstr("with fewer than eight runs the test decides nothing"));
  data.fit.runs_test_p_value = 0.002;
  EXPECT_THAT(
      check_of(data),
      HasSubstr(
          "<b>Runs test: p = 0.002</b> (threshold 0.01): residuals of neighbouring runs have the same"));
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

TEST(CheckSection, ModelsAreComparedWithTheOneFitted) {
  ReportData data = sample::campaign();
  data.fit.models = {{"Coulomb friction", 3, 40.0, 46.0, 50.0, {}, ""},
                     {"tilt", 5, 20.0, 30.0, 37.0, {}, "tilt_x = <1>"}};
  data.fit.left_out = {"Rival friction laws were not tried: tilt explains the residuals."};
  const std::string html = check_of(data);
  EXPECT_THAT(html, HasSubstr("<td><b>Coulomb friction</b> (fitted)</td><td class=\"n\">3</td><td "
                              "class=\"n\">40</td><td class=\"n\">46</td><td class=\"n\"></td>"));
  EXPECT_THAT(html,
              HasSubstr("<td>tilt</td><td class=\"n\">5</td><td class=\"n\">20</td><td class=\"n\">30</td>"
                        "<td class=\"n\">−16.0</td><td class=\"n\">37</td><td class=\"n\">−13.0</td>"
                        "<td>tilt_x = &lt;1&gt;</td>"));
  EXPECT_THAT(html, HasSubstr("<li>Rival friction laws were not tried: tilt explains the residuals.</li>"));
}

TEST(CheckSection, IsLeftOutWithoutAFit) {
  EXPECT_EQ(check_of(ReportData{}), "");
}

}  // namespace
}  // namespace tribotrack::apps
