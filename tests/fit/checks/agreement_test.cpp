// The fit's own verdict on the model and on its values.
#include "fit/checks/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fit/tools/statistics.h"

namespace tribotrack::fit::internal {
namespace {

FitResult fitted(double chi2, int dof) {
  FitResult result;
  result.chi2 = chi2;
  result.dof = dof;
  result.p_value = chi2_survival(chi2, dof);
  return result;
}

TEST(Agreement, IsChiSquaresWithinItsLevels) {
  EXPECT_EQ(agreement(fitted(25, 25)), Agreement::good);
  EXPECT_EQ(agreement(fitted(chi2_quantile(0.9985, 25), 25)), Agreement::good);
  EXPECT_EQ(agreement(fitted(chi2_quantile(0.9995, 25), 25)), Agreement::poor);
  EXPECT_EQ(agreement(fitted(chi2_quantile(0.006, 25), 25)), Agreement::good);
  EXPECT_EQ(agreement(fitted(chi2_quantile(0.004, 25), 25)), Agreement::too_good);
  EXPECT_EQ(agreement(fitted(0, 0)), Agreement::unknown);
  FitResult by_points = fitted(5, 25);
  EXPECT_EQ(agreement(by_points), Agreement::too_good);
  by_points.noise_dof = 1000;
  EXPECT_EQ(agreement(by_points), Agreement::good) << "no errors were stated";
}

TEST(Agreement, ThatScatterMadeIsNoCheckOfTheModel) {
  FitResult result = fitted(100, 25);
  result.scatter = 1e-5;
  EXPECT_EQ(agreement(result), Agreement::only_with_scatter);
}

TEST(Agreement, ExpectedRangeIsThatOfTheTables) {
  EXPECT_NEAR(expected_reduced_chi2(10).low, 2.15586 / 10, 1e-6);
  EXPECT_NEAR(expected_reduced_chi2(10).high, 25.18818 / 10, 1e-6);
  EXPECT_EQ(expected_reduced_chi2(0).high, 0);
}

FitResult sound() {
  FitResult result = fitted(25, 25);
  result.converged = true;
  result.agreement = Agreement::good;
  return result;
}

Use judged(FitResult& result) {
  judge(result);
  return result.verdict;
}

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Judge, ARejectedModelThatNothingExplainsIsNot) {
  FitResult result = sound();
  result.p_value = 1e-4;
  EXPECT_EQ(judged(result), Use::do_not_use);
  EXPECT_THAT(result.verdict_reasons, ElementsAre(HasSubstr("nothing looked at explains it")));
  result.quoted_under = {"a tilt of the platform"};
  EXPECT_EQ(judged(result), Use::care);
  EXPECT_THAT(result.verdict_reasons, ElementsAre(HasSubstr("hold under a tilt of the platform")));
  result.quoted_under.clear();
  result.scatter_from_replicates = true;
  EXPECT_EQ(judged(result), Use::care);
  EXPECT_THAT(result.verdict_reasons, ElementsAre(HasSubstr("repeated runs")));
}

TEST(Judge, EachFaultForbidsAndEachDoubtIsNamed) {
  const auto with = [](auto change) {
    FitResult result = sound();
    change(result);
    judge(result);
    return result;
  };
  for (const FitResult& result :
       {with([](FitResult& r) { r.converged = false; }),
        with([](FitResult& r) { r.scatter_dominates = true; }),
        with([](FitResult& r) { r.identifiability.verdict = Verdict::not_identifiable; })}) {
    EXPECT_EQ(result.verdict, Use::do_not_use);
    EXPECT_EQ(result.verdict_reasons.size(), 1U);
  }
  const auto doubt = [&](auto change) {
    const FitResult result = with(change);
    EXPECT_EQ(result.verdict, Use::care);
    return result.verdict_reasons.empty() ? "" : result.verdict_reasons.front();
  };
  EXPECT_THAT(doubt([](FitResult& r) { r.agreement = Agreement::too_good; }),
              HasSubstr("errors look too large"));
  EXPECT_THAT(doubt([](FitResult& r) { r.agreement = Agreement::unknown; }),
              HasSubstr("no data left to check"));
  EXPECT_THAT(doubt([](FitResult& r) { r.identifiability.verdict = Verdict::weak; }), HasSubstr("weakly"));
  EXPECT_THAT(doubt([](FitResult& r) { r.outliers.resize(1); }), HasSubstr("one run contradicts the others"));
  EXPECT_THAT(doubt([](FitResult& r) { r.minima.resize(2); }), HasSubstr("other values fit nearly as well"));
  EXPECT_THAT(doubt([](FitResult& r) {
                r.slides.resize(2);
                r.between_slides.p_value = 1e-9;
              }),
              HasSubstr("differs from slide to slide"));
  EXPECT_THAT(doubt([](FitResult& r) { r.slides.resize(1), r.slides.front().blows.resize(1); }),
              HasSubstr("struck on its way"));
  // Points of a track err alike for longer than chi^2 knows.
  EXPECT_THAT(doubt([](FitResult& r) {
                r.runs.resize(1), r.runs.front().points = 500;
                r.p_value = 0;
              }),
              HasSubstr("p < 1e-300; the intervals count what they share"));
}

}  // namespace
}  // namespace tribotrack::fit::internal
