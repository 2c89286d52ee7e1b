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
  data.fit.chi2 = 48.7;
  data.fit.dof = 25;
  data.fit.agreement = fit::Agreement::good;
  EXPECT_EQ(verdict_of(data).heading, "Can be used");
  data.fit.agreement = fit::Agreement::poor;
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("data contradict the model"));
  data.fit.agreement = fit::Agreement::only_with_scatter;
  data.fit.scatter = 1e-5;
  EXPECT_THAT(verdict_of(data).paragraph, HasSubstr("no longer tests the model"));
}

TEST(ReportVerdict, AFitThatDidNotConvergeMustNotBeUsed) {
  ReportData data = all_well();
  data.fit.converged = false;
  EXPECT_EQ(verdict_of(data).trust, Trust::do_not_use);
}

TEST(ReportVerdict, AFitThatIsNotIdentifiableMustNotBeUsed) {
  ReportData data = all_well();
  data.fit.identifiability.verdict = fit::Verdict::not_identifiable;
  EXPECT_EQ(verdict_of(data).trust, Trust::do_not_use);
}

TEST(ReportVerdict, EachDoubtIsNamedInTheHeading) {
  const auto heading = [](auto change) {
    ReportData data = all_well();
    change(data);
    EXPECT_EQ(verdict_of(data).trust, Trust::with_care);
    return verdict_of(data).heading;
  };
  EXPECT_THAT(heading([](ReportData& d) { d.fit.agreement = fit::Agreement::poor; }),
              HasSubstr("data contradict the model"));
  EXPECT_THAT(heading([](ReportData& d) { d.fit.agreement = fit::Agreement::too_good; }),
              HasSubstr("errors look too large"));
  EXPECT_THAT(heading([](ReportData& d) { d.fit.agreement = fit::Agreement::unknown; }),
              HasSubstr("no data left to check"));
  EXPECT_THAT(heading([](ReportData& d) { d.fit.identifiability.verdict = fit::Verdict::weak; }),
              HasSubstr("weakly"));
  EXPECT_THAT(heading([](ReportData& d) { d.runs[0].failure = "gone"; }), HasSubstr("one run failed"));
  EXPECT_THAT(heading([](ReportData& d) { d.fit.outliers.resize(1); }),
              HasSubstr("one run contradicts the others"));
  EXPECT_THAT(heading([](ReportData& d) { d.fit.minima.resize(2); }),
              HasSubstr("other values fit nearly as well"));
}

TEST(ReportVerdict, WithoutAFitItSpeaksOfMeasurementsOnly) {
  EXPECT_EQ(verdict_of(ReportData{}).trust, Trust::no_fit);
}

TEST(ReportVerdict, SlidesThatNeededScatterAreNotPassedOver) {
  ReportData data = all_well();
  data.fit.agreement = fit::Agreement::only_with_scatter;
  data.fit.scatter = 1e-5;
  data.fit.p_value = 0;
  data.fit.slides.resize(1);
  const Verdict verdict = verdict_of(data);
  EXPECT_EQ(verdict.trust, Trust::with_care);
  EXPECT_THAT(verdict.heading, HasSubstr("free slides deviate from the law of friction"));
  EXPECT_THAT(verdict.heading, HasSubstr("p below 1e-300"));
}

TEST(ReportVerdict, SlidesThatDifferOrWereStruckAreNamed) {
  ReportData data = all_well();
  data.fit.slides.resize(2);
  data.fit.between_slides_p_value = 0.2;
  EXPECT_EQ(verdict_of(data).heading, "Can be used");
  data.fit.between_slides_p_value = 1e-9;
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("differs from slide to slide by more than chance"));
  data.fit.slides.front().blows.resize(1);
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("a slide was struck on its way"));
}

}  // namespace
}  // namespace tribotrack::apps
