// Transforms and profiles at the edge.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"
#include "fit/tools/transform.h"
#include "fit/uncertainty/profile.h"

namespace tribotrack::fit {
namespace {

TEST(Transform, IsItsOwnInverseAndKnowsItsSlope) {
  using internal::Transform;
  for (const auto kind : {Transform::Kind::linear, Transform::Kind::logarithm, Transform::Kind::hyperbola}) {
    const Transform transform(kind, 0.005);
    for (const double value : {1e-6, 1e-3, 0.0125, 0.1, 3.0}) {
      const double z = transform.z(value);
      EXPECT_NEAR(transform.value(z), value, 1e-12 * value);
      const double h = 1e-5 * std::max(1.0, std::abs(z));
      EXPECT_NEAR((transform.value(z + h) - transform.value(z - h)) / (2 * h), transform.slope(z),
                  1e-7 * std::abs(transform.slope(z)));
    }
    if (transform.positive()) {
      EXPECT_GE(transform.value(-1e9), 0);
    }
  }
}

// mu2 = 0 is legal: its interval is one-sided and closed by 0.
TEST(Profile, Mu2CompatibleWithZeroIsOneSided) {
  std::mt19937 random(2);
  Problem problem = test::problem_of(test::fourteen({0.1, 0.0004, 0.1}), 0.03, 0.2e-3, &random);
  FitOptions options{.multi_starts = 2};
  const FitResult result = estimate(problem, options);
  const auto& mu2 = result.parameters[1];
  EXPECT_EQ(mu2.profile_ci95.low, 0);
  EXPECT_EQ(mu2.ci95.low, 0);
  EXPECT_GT(mu2.profile_ci95.high, 0.0004);
  EXPECT_LT(mu2.profile_ci95.high, 0.01);
  EXPECT_LT(mu2.estimate, mu2.profile_ci95.high);
}

// Handed a place that is no minimum as if it were one, the profiles find the better one and start anew.
TEST(Profile, ABetterOptimumRestartsThem) {
  using namespace internal;
  std::mt19937 random(9);
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  for (const auto& s : test::fourteen({}))
    if (s.friction.phase < 0.5) problem.summary_runs.push_back(test::summary_run(s, 0.03, 0.2e-3, &random));
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  const Eigen::Vector3d truth(0.1, 0.0125, 0.1);
  std::vector<Minimum> best = {linearised(residuals, minimise(residuals, unknowns.z(truth)))};
  const double lowest = best.front().chi2;
  const std::vector<bool> open(3, false);
  const std::vector<double> rises(3, 3.84);
  const auto expected = profiles(residuals, best, {}, open, rises, 1);
  EXPECT_EQ(best.front().chi2, lowest);

  Minimum mistaken;
  mistaken.z = unknowns.z(Eigen::Vector3d(1.05 * truth(0), truth(1), truth(2) - 0.1));
  mistaken.chi2 = residuals.chi2(unknowns.values(mistaken.z));
  ASSERT_GT(mistaken.chi2, lowest + 1);
  std::vector<Minimum> restarted = {linearised(residuals, mistaken)};
  const auto found = profiles(residuals, restarted, {}, open, rises, 2);
  EXPECT_NEAR(restarted.front().chi2, lowest, 1e-6);
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_EQ(found[i].pieces.size(), 1U);
    const Interval &there = found[i].pieces.front(), &here = expected[i].pieces.front();
    EXPECT_NEAR(there.low, here.low, 0.02 * (here.high - here.low));
    EXPECT_NEAR(there.high, here.high, 0.02 * (here.high - here.low));
  }
}

}  // namespace
}  // namespace tribotrack::fit
