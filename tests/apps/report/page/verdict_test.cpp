#include "apps/report/page/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;
using testing::Not;

ReportData all_well() {
  ReportData data = sample::campaign();
  data.warnings.clear();
  std::erase_if(data.runs, [](const ReportRun& run) { return !run.failure.empty(); });
  return data;
}

// Quantiles 0.005 and 0.995 of chi-squared from printed tables (Abramowitz and Stegun, table 26.8).
TEST(ReportVerdict, TheExpectedRangeOfChiSquaredIsTheTables) {
  const struct {
    int dof;
    double low, high;
  } table[] = {{1, 3.927e-5, 7.8794},  {2, 0.010025, 10.5966}, {5, 0.41174, 16.7496},
               {10, 2.15586, 25.1882}, {30, 13.7867, 53.6720}, {100, 67.3276, 140.169}};
  for (const auto& row : table) {
    const ReportInterval range = expected_reduced_chi2(row.dof);
    EXPECT_NEAR(range.low * row.dof, row.low, 2e-4 * row.low) << row.dof;
    EXPECT_NEAR(range.high * row.dof, row.high, 2e-5 * row.high) << row.dof;
  }
  EXPECT_TRUE(std::isnan(expected_reduced_chi2(0).low));
}

TEST(ReportVerdict, TheExpectedRangeIsWrittenSoThatItsWidthIsSeen) {
  EXPECT_EQ(expected_chi2_text(25), "0.42 to 1.88");
  EXPECT_EQ(expected_chi2_text(13315), "0.969 to 1.032");
}

TEST(ReportVerdict, AGoodFitCanBeUsedAndSaysItsValues) {
  const Verdict verdict = verdict_of(all_well());
  EXPECT_EQ(verdict.trust, Trust::usable);
  EXPECT_EQ(verdict.heading, "Can be used");
  EXPECT_THAT(verdict.paragraph, HasSubstr("μ<sub>1</sub> = 0.10012 ± 0.00031"));
  EXPECT_THAT(verdict.paragraph, HasSubstr("0.09952 to 0.10073"));
  EXPECT_THAT(verdict.paragraph, HasSubstr("lag = 0.2991 ± 0.0046 rad"));
  EXPECT_THAT(verdict.paragraph, Not(HasSubstr("warning")));
}

// chi2 = 48.7 at 25 degrees of freedom, p = 0.003: the fit does not call it a surprise, nor may the page.
TEST(ReportVerdict, TheFitsOwnThresholdDecidesWhetherTheModelMisses) {
  ReportData data = all_well();
  data.dof = 25;
  data.chi2 = 48.7;
  data.p_value = 0.003;
  EXPECT_EQ(verdict_of(data).heading, "Can be used");
  data.p_value = 0.0009;
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("data contradict the model"));
}

TEST(ReportVerdict, AFitThatDidNotConvergeMustNotBeUsed) {
  ReportData data = all_well();
  data.converged = false;
  EXPECT_EQ(verdict_of(data).trust, Trust::do_not_use);
}

TEST(ReportVerdict, AFitThatIsNotIdentifiableMustNotBeUsed) {
  ReportData data = all_well();
  data.identifiability = ReportVerdict::not_identifiable;
  EXPECT_EQ(verdict_of(data).trust, Trust::do_not_use);
}

TEST(ReportVerdict, EachDoubtIsNamedInTheHeading) {
  const auto heading = [](auto change) {
    ReportData data = all_well();
    change(data);
    EXPECT_EQ(verdict_of(data).trust, Trust::with_care);
    return verdict_of(data).heading;
  };
  EXPECT_THAT(heading([](ReportData& d) { d.chi2 = 10.0 * d.dof; }), HasSubstr("data contradict the model"));
  EXPECT_THAT(heading([](ReportData& d) { d.chi2 = 0.01 * d.dof; }), HasSubstr("errors look too large"));
  EXPECT_THAT(heading([](ReportData& d) { d.dof = 0; }), HasSubstr("no data left to check"));
  EXPECT_THAT(heading([](ReportData& d) { d.identifiability = ReportVerdict::weak; }), HasSubstr("weakly"));
  EXPECT_THAT(heading([](ReportData& d) { d.runs[0].failure = "gone"; }), HasSubstr("one run failed"));
}

TEST(ReportVerdict, WithoutAFitItSpeaksOfMeasurementsOnly) {
  ReportData data = all_well();
  data.fitted = false;
  EXPECT_EQ(verdict_of(data).trust, Trust::no_fit);
  EXPECT_EQ(verdict_of(ReportData{}).trust, Trust::no_fit);
}

}  // namespace
}  // namespace tribotrack::apps
