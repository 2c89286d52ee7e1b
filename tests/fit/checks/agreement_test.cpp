// The fit's own verdict on the model.
#include "fit/checks/outliers.h"

#include <gtest/gtest.h>

#include "fit/tools/statistics.h"

namespace tribotrack::fit::internal {
namespace {

FitResult fitted(double chi2, int dof) {
  FitResult result;
  result.chi2 = result.chi2_before_scatter = chi2;
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
}

TEST(Agreement, ThatScatterMadeIsNoCheckOfTheModel) {
  FitResult result = fitted(100, 25);
  result.scatter = 1e-5;
  result.chi2 = 25;
  EXPECT_EQ(agreement(result), Agreement::only_with_scatter);
  result.p_value = 0.3;  // repeated runs show the scatter, and with it the model agrees
  EXPECT_EQ(agreement(result), Agreement::good);
}

TEST(Agreement, ExpectedRangeIsThatOfTheTables) {
  EXPECT_NEAR(expected_reduced_chi2(10).low, 2.15586 / 10, 1e-6);
  EXPECT_NEAR(expected_reduced_chi2(10).high, 25.18818 / 10, 1e-6);
  EXPECT_EQ(expected_reduced_chi2(0).high, 0);
}

}  // namespace
}  // namespace tribotrack::fit::internal
