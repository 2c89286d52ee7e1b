#include "apps/report/findings/verdict.h"

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

TEST(ReportVerdict, TheExpectedRangeIsWrittenSoThatItsWidthIsSeen) {
  EXPECT_EQ(expected_chi2_text(25), "0.42 to 1.88");
  EXPECT_EQ(expected_chi2_text(13315), "0.969 to 1.032");
}

TEST(ReportVerdict, AGoodFitCanBeUsedAndSaysWhy) {
  const Verdict verdict = verdict_of(all_well());
  EXPECT_EQ(verdict.trust, Trust::usable);
  EXPECT_EQ(verdict.heading, "Can be used");
  EXPECT_THAT(verdict.paragraph,
              HasSubstr("The fit to 15 runs converged, and the data determine every parameter."));
  EXPECT_THAT(verdict.paragraph, HasSubstr("within their errors"));
  EXPECT_THAT(verdict.paragraph, Not(HasSubstr("warning")));
}

TEST(ReportVerdict, TheFitDecidesWhetherTheModelAgrees) {
  ReportData data = all_well();
  data.chi2 = 48.7;
  data.dof = 25;
  data.agreement = fit::Agreement::good;
  EXPECT_EQ(verdict_of(data).heading, "Can be used");
  data.agreement = fit::Agreement::poor;
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("data contradict the model"));
  data.agreement = fit::Agreement::only_with_scatter;
  data.scatter_mm = 0.01;
  EXPECT_THAT(verdict_of(data).paragraph, HasSubstr("no longer tests the model"));
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
  EXPECT_THAT(heading([](ReportData& d) { d.agreement = fit::Agreement::poor; }),
              HasSubstr("data contradict the model"));
  EXPECT_THAT(heading([](ReportData& d) { d.agreement = fit::Agreement::too_good; }),
              HasSubstr("errors look too large"));
  EXPECT_THAT(heading([](ReportData& d) { d.agreement = fit::Agreement::unknown; }),
              HasSubstr("no data left to check"));
  EXPECT_THAT(heading([](ReportData& d) { d.identifiability = ReportVerdict::weak; }), HasSubstr("weakly"));
  EXPECT_THAT(heading([](ReportData& d) { d.runs[0].failure = "gone"; }), HasSubstr("one run failed"));
}

TEST(ReportVerdict, WithoutAFitItSpeaksOfMeasurementsOnly) {
  ReportData data = all_well();
  data.fitted = false;
  EXPECT_EQ(verdict_of(data).trust, Trust::no_fit);
  EXPECT_EQ(verdict_of(ReportData{}).trust, Trust::no_fit);
}

TEST(ReportVerdict, SlidesThatNeededScatterAreNotPassedOver) {
  ReportData data = all_well();
  data.agreement = fit::Agreement::only_with_scatter;
  data.scatter_mm = 0.01;
  data.p_value = 0;
  data.slide_results.push_back({.name = "head on", .mu1 = 0.16, .mu1_sd = 0.002});
  const Verdict verdict = verdict_of(data);
  EXPECT_EQ(verdict.trust, Trust::with_care);
  EXPECT_THAT(verdict.heading, HasSubstr("free slides deviate from the law of friction"));
  EXPECT_THAT(verdict.heading, HasSubstr("p below 1e-300"));
}

TEST(ReportVerdict, SlidesThatDifferOrWereStruckAreNamed) {
  ReportData data = all_well();
  data.slide_results.push_back({.name = "a", .mu1 = 0.148, .mu1_sd = 0.002});
  data.slide_results.push_back({.name = "b", .mu1 = 0.204, .mu1_sd = 0.002});
  data.between_slides_p_value = 0.2;
  EXPECT_EQ(verdict_of(data).heading, "Can be used");
  data.between_slides_p_value = 1e-9;
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("differs from slide to slide by more than chance"));
  data.slide_results.front().blow_frames = {231};
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("a slide was struck on its way"));
}

}  // namespace
}  // namespace tribotrack::apps
