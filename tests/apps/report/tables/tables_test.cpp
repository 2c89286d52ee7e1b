#include "apps/report/tables/tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "apps/program.h"
#include "apps/report_sample.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) list.push_back(line);
  return list;
}

std::string cell(const std::string& csv, std::size_t row, const std::string& column) {
  const auto cells = [](const std::string& line) {
    std::vector<std::string> list;
    std::istringstream stream(line + ",");
    for (std::string one; std::getline(stream, one, ',');) list.push_back(one);
    return list;
  };
  const std::vector<std::string> head = cells(lines(csv)[0]), values = cells(lines(csv)[row]);
  EXPECT_EQ(head.size(), values.size()) << "row " << row;
  const auto at = std::ranges::find(head, column) - head.begin();
  return values.at(static_cast<std::size_t>(at));
}

TEST(RunsCsv, HasARowForEachRunWithAllDigits) {
  ReportData data = sample::campaign();
  data.runs[0].measured["alpha_rad"].value = 1.0 / 3;
  const std::string csv = runs_csv(data);
  EXPECT_EQ(lines(csv).size(), 1 + data.runs.size());
  EXPECT_EQ(cell(csv, 1, "alpha_rad"), "0.3333333333333333");
  EXPECT_EQ(cell(csv, 1, "dx_residual_sd"), exact(data.runs[0].fitted.residuals[0].standardised));
  EXPECT_EQ(cell(csv, 8, "frames_lost"), "3");
  EXPECT_EQ(cell(csv, 8, "frames_repeated"), "0");
  EXPECT_EQ(cell(csv, 14, "frame_rate_hz"), "") << "measured elsewhere";
}

TEST(ParametersCsv, HoldsIntervalsAndCorrelationsAndLeavesOpenEndsEmpty) {
  ReportData data = sample::campaign();
  data.fit.parameters[1].ci95.high = std::numeric_limits<double>::infinity();
  const std::string csv = parameters_csv(data);
  EXPECT_EQ(cell(csv, 1, "estimate"), "0.100123");
  EXPECT_EQ(cell(csv, 2, "ci95_high"), "");
  EXPECT_EQ(cell(csv, 2, "correlation_with_mu1"), "0.42");
  EXPECT_EQ(cell(csv, 3, "profile_ci95_low"), "0.2899");
}

TEST(ReportText, IsOneBlockToPaste) {
  const std::string text = report_text(sample::campaign());
  EXPECT_THAT(text, HasSubstr("Silver-coated disc, 6 mm, on polished duralumin\n"));
  EXPECT_THAT(text, HasSubstr("0.10012(31)"));
  EXPECT_THAT(text, HasSubstr("95 %: 0.09952 to 0.10073"));
  EXPECT_THAT(text, HasSubstr("correlation of mu2 and mu1: 0.42"));
  EXPECT_THAT(text, HasSubstr("chi2 = 26.4 with 27 degrees of freedom"));
  EXPECT_THAT(text, HasSubstr("tracking noise"));
  EXPECT_THAT(text, HasSubstr("Computed with tribotrack 0.1.0."));
  EXPECT_EQ(test::occurrences(text, "<"), 0u) << "no HTML in it";
}

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

ReportData all_well() {
  ReportData data = sample::campaign();
  data.warnings.clear();
  std::erase_if(data.runs, [](const ReportRun& run) { return !run.failure.empty(); });
  return data;
}

TEST(ReportVerdict, TheExpectedRangeIsWrittenSoThatItsWidthIsSeen) {
  EXPECT_EQ(expected_chi2_text(25), "0.42 to 1.88");
  EXPECT_EQ(expected_chi2_text(13315), "0.969 to 1.032");
}

// The fit decides and gives the reasons; the page adds runs that failed.
TEST(ReportVerdict, IsThatOfTheFit) {
  ReportData data = all_well();
  data.fit.verdict = fit::Use::care;
  data.fit.verdict_reasons = {"the values hold under a tilt", "one run <a> contradicts the others"};
  EXPECT_STREQ(verdict_of(data).style, "care");
  EXPECT_EQ(verdict_of(data).heading,
            "Use with care: the values hold under a tilt; one run <a> contradicts the others");
  data.runs[0].failure = "gone";
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("others; one run failed"));
  data.fit.verdict = fit::Use::do_not_use;
  EXPECT_EQ(verdict_of(data).heading, "Do not use these values");
  EXPECT_THAT(verdict_of(data).paragraph, StartsWith("The values hold under a tilt; one run"));
  data = all_well();
  data.runs[0].failure = "gone";
  EXPECT_EQ(verdict_of(data).heading, "Use with care: one run failed");
}

}  // namespace
}  // namespace tribotrack::apps
