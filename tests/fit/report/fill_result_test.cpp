#include "fit/report/fill_result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fit/campaign.h"

namespace tribotrack::fit::internal {
namespace {

/// Trial values without a motion are reported; near the minimum they bound the intervals, and a warning says
/// so.
TEST(FillResult, FailuresNearTheMinimumAreWarnedOf) {
  const test::Truth truth{0.1, 1e-3, 0.1};
  Problem problem;
  using enum FitParameter;
  problem.free = {mu1, mu2, lag};
  problem.start = {{mu1, truth.mu1}, {mu2, truth.mu2}, {lag, truth.lag}};
  for (const auto& scenario : test::fourteen(truth))
    problem.summary_runs.push_back(test::summary_run(scenario, 0.1, 0.2e-3));
  const Unknowns unknowns(problem);
  const Residuals residuals(unknowns);
  const Minimum best = minimise(residuals, unknowns.z(unknowns.first_guess()));
  ASSERT_TRUE(best.converged);

  FitResult result;
  Eigen::VectorXd r, far = unknowns.values(best.z), near = far;
  far(0) = -0.1;
  EXPECT_FALSE(residuals.evaluate(far, r, nullptr));
  fill_failures(residuals, best, result);
  EXPECT_EQ(result.failed_evaluations, 1);
  EXPECT_TRUE(result.warnings.empty());

  near(1) = -1e-6;
  EXPECT_FALSE(residuals.evaluate(near, r, nullptr));
  fill_failures(residuals, best, result);
  EXPECT_EQ(result.failed_evaluations, 2);
  ASSERT_EQ(result.warnings.size(), 1);
  EXPECT_THAT(result.warnings.front(),
              testing::HasSubstr("at 1 of the values tried within three standard dev"));
  EXPECT_THAT(result.warnings.front(), testing::HasSubstr("mu2"));
}

}  // namespace
}  // namespace tribotrack::fit::internal
