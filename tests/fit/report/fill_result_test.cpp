#include "fit/report/fill_result.h"

#include <gtest/gtest.h>

#include "fit/campaign.h"

namespace tribotrack::fit::internal {
namespace {

Problem fourteen_runs() {
  const test::Truth truth{0.1, 1e-3, 0.1};
  Problem problem;
  using enum FitParameter;
  problem.free = {mu1, mu2, lag};
  problem.start = {{mu1, truth.mu1}, {mu2, truth.mu2}, {lag, truth.lag}};
  for (const auto& scenario : test::fourteen(truth))
    problem.summary_runs.push_back(test::summary_run(scenario, 0.1, 0.2e-3));
  return problem;
}

/// An error of the platform's phase stands in the lag radian for radian, and nowhere else.
TEST(Conditions, OfThePhaseStandInTheLag) {
  FitOptions options{.next_experiment = false};
  Problem problem = fourteen_runs();
  const FitResult alone = estimate(problem, options);
  problem.conditions = {{FitParameter::phase_reference, 0.05, "sensor"}};
  const FitResult result = estimate(problem, options);
  EXPECT_EQ(alone.sd_from("sensor").norm(), 0);
  for (const std::size_t i : {0, 1})
    EXPECT_NEAR(result.parameters[i].sd, alone.parameters[i].sd, 1e-6 * alone.parameters[i].sd);
  EXPECT_NEAR(result.parameters[2].sd, std::hypot(alone.parameters[2].sd, 0.05), 1e-6);
  EXPECT_GT(result.parameters[2].ci95.high, alone.parameters[2].ci95.high);
  EXPECT_LT(result.parameters[2].profile_ci95.low, alone.parameters[2].profile_ci95.low);
  EXPECT_NEAR(result.sd_from("sensor")(2), 0.05, 1e-6);
}

}  // namespace
}  // namespace tribotrack::fit::internal
