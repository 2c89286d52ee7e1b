// Ends of profiles against what they mean: a fit with the parameter held there.
#include <gtest/gtest.h>

#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

double chi2_with(Problem problem, FitParameter parameter, double value) {
  std::erase(problem.free, parameter);
  problem.fixed[parameter] = value;
  FitOptions search_alone{.profiles = false, .next_experiment = false, .estimate_scatter = false};
  return estimate(problem, search_alone).chi2;
}

// Conditions and laws enter linearly, and what they do changes from one end of an interval to the other.
TEST(Profile, AFitHeldAtAnEndRisesByTheLevelWhateverElseIsUncertain) {
  std::mt19937 random(5);
  Problem problem = test::problem_of(test::fourteen({}), 0.002, 0.01e-3, &random);
  problem.conditions = {
      {FitParameter::amplitude, 1.4e-6, "test"}, {FitParameter::amplitude_ratio, 0.01, "test"},
      {FitParameter::tilt_x, 0.002, "test"},     {FitParameter::tilt_y, 0.002, "test"},
      {FitParameter::viscous, 1, "test"},        {FitParameter::stribeck, 0.1, "test"},
      {FitParameter::gate_edges, 0.1, "test"}};
  const FitResult fit = estimate(problem, {});
  for (const ParameterEstimate& p : fit.parameters)
    for (const double end : {p.profile_ci95.low, p.profile_ci95.high})
      EXPECT_NEAR(chi2_with(problem, p.parameter, end) - fit.chi2, p.profile_level, 0.08 * p.profile_level)
          << to_string(p.parameter) << " = " << end;
}

}  // namespace
}  // namespace tribotrack::fit
