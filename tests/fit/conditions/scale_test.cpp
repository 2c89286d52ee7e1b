// Everything that a picture shows goes with its scale, and friction with it: what is known of the scale is
// what is known of mu1, however good the tracks are.
#include <gtest/gtest.h>

#include <cmath>

#include "fit/campaign.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

TEST(SharedScale, IsInFrictionAsItIs) {
  constexpr double kScaleSd = 0.005;
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  for (const model::Scenario& scenario : test::fourteen({})) {
    problem.summary_runs.push_back(test::summary_run(scenario, 1e-4, 2e-7));
    problem.summary_runs.back().measured.given_as_velocity = false;
    problem.summary_runs.back().amplitude_from_track = true;
  }
  problem.conditions = {{FitParameter::scale, kScaleSd, "diameter"}, {FitParameter::tilt_x, 2e-3, "level"}};
  const FitResult result = estimate(problem, {.next_experiment = false});
  const ParameterEstimate& mu1 = result.parameters[0];
  EXPECT_NEAR(mu1.estimate, 0.1, 1e-4);
  EXPECT_NEAR(mu1.sd / mu1.estimate, kScaleSd, 0.02 * kScaleSd);
  for (const double end : {mu1.profile_ci95.low, mu1.profile_ci95.high})
    EXPECT_NEAR(std::abs(std::log(end / mu1.estimate)), 1.96 * kScaleSd, 0.03 * kScaleSd);
}

}  // namespace
}  // namespace tribotrack::fit
