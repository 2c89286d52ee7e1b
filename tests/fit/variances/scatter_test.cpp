// Scatter between runs, from repetitions where there are any.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

FitOptions quick() {
  return {.multi_starts = 2, .profiles = false, .next_experiment = false};
}

/// The fourteen, `times` each, with a sigma of 1e-5 m and scattering by what stands there.
Problem scattered(int times, double along, double across, std::mt19937& random, double tilt = 0) {
  std::normal_distribution<double> normal;
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  for (auto scenario : test::fourteen({})) {
    scenario.drive.tilt_x = tilt;
    SummaryRun exact = test::summary_run(scenario, 0.01, 1e-5);
    exact.measured.covariance = 1e-10 * Eigen::Matrix2d::Identity();
    exact.scenario.drive.tilt_x = 0;
    const Eigen::Vector2d u = exact.measured.vector.normalized(), v(-u.y(), u.x());
    for (int k = 0; k < times; ++k) {
      SummaryRun run = exact;
      run.name = "run" + std::to_string(problem.summary_runs.size());
      run.measured.vector += std::hypot(along, 1e-5) * normal(random) * u;
      run.measured.vector += std::hypot(across, 1e-5) * normal(random) * v;
      problem.summary_runs.push_back(run);
    }
  }
  return problem;
}

TEST(ExcessVariance, RepetitionsTellItAndChiSquareKeepsItsMeaning) {
  std::mt19937 random(14);
  const FitResult result = estimate(scattered(3, 6e-5, 6e-5, random), quick());
  EXPECT_TRUE(result.scatter_from_replicates);
  EXPECT_EQ(result.replicate_dof, 56);
  EXPECT_NEAR(result.scatter, 6e-5, 4 * 6e-5 / std::sqrt(2 * 56.0));
  EXPECT_LT(result.p_value, 1e-3) << "before any scatter";
  EXPECT_EQ(result.verdict, Use::care);
  EXPECT_THAT(result.verdict_reasons, Contains(HasSubstr("repeated runs differ by more")));
  EXPECT_TRUE(result.quoted_under.empty());
  EXPECT_THAT(result.covariance_meaning, HasSubstr("a scatter estimated from repeated runs"));
  EXPECT_THAT(result.warnings, Contains(HasSubstr("with that the fit agrees with all runs")));
}

TEST(ExcessVariance, AWrongModelIsSeenBesideTheScatterOfRepetitions) {
  std::mt19937 random(15);
  Problem problem = scattered(2, 3e-5, 3e-5, random, 0.002);
  auto& runs = problem.summary_runs;
  for (std::size_t k = 0; k < 14; k += 2)  // every other pair: seven of them
    runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(k),
               runs.begin() + static_cast<std::ptrdiff_t>(k + 2));
  const FitResult result = estimate(problem, quick());
  EXPECT_LT(result.p_value, 1e-3);
  EXPECT_EQ(result.explanations.front().name, "tilt");
  EXPECT_THAT(result.quoted_under, ElementsAre(HasSubstr("a tilt of the platform")));
  EXPECT_TRUE(result.scatter_from_replicates) << "beside it";
  EXPECT_THAT(result.verdict_reasons, Contains(HasSubstr("hold under a tilt")));
}

}  // namespace
}  // namespace tribotrack::fit
