#include "apps/report/tables/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

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
  EXPECT_STREQ(verdict.style, "good");
  EXPECT_EQ(verdict.heading, "Can be used");
  EXPECT_THAT(verdict.paragraph,
              HasSubstr("The fit to 15 runs converged. χ² per degree of freedom is 0.978"));
  EXPECT_THAT(verdict.paragraph, Not(HasSubstr("warning")));
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

TEST(ReportVerdict, WithoutAFitItSpeaksOfMeasurementsOnly) {
  EXPECT_STREQ(verdict_of(ReportData{}).style, "none");
}

}  // namespace
}  // namespace tribotrack::apps
