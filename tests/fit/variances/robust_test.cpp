// Outliers named, losses they cannot pull, and the bootstrap beside the other intervals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"
#include "fit/variances/excess_variance.h"

namespace tribotrack::fit {
namespace {

using test::Truth;
using testing::HasSubstr;
constexpr double pi = std::numbers::pi;

Problem noisy(const Truth& truth, std::mt19937& random, double alpha_sd = 0.01, double v_sd = 0.05e-3) {
  return test::problem_of(test::fourteen(truth), alpha_sd, v_sd, &random);
}

FitOptions quick() {
  return {.profiles = false, .next_experiment = false};
}

TEST(Robust, OneBadRunDoesNotPull) {
  std::mt19937 random(3);
  const Truth truth;
  const Problem good = noisy(truth, random);
  Problem bad = good;
  bad.summary_runs[4].measured.vector += Eigen::Vector2d(2e-3, -1e-3);
  FitOptions options = quick();
  const FitResult reference = estimate(good, options);
  const FitResult squares = estimate(bad, options);
  const double pulled =
      std::abs(squares.as_assumed.at(FitParameter::mu1).estimate - reference.value(FitParameter::mu1));
  EXPECT_THAT(squares.quoted_under, testing::ElementsAre(HasSubstr("contradicts the others")));
  EXPECT_LT(std::abs(squares.value(FitParameter::mu1) - reference.value(FitParameter::mu1)), 0.35 * pulled);
  options.loss = Loss::huber;
  const FitResult robust = estimate(bad, options);
  EXPECT_TRUE(robust.usable());
  EXPECT_THAT(robust.covariance_meaning, HasSubstr("Huber"));
  EXPECT_THAT(robust.covariance_meaning, HasSubstr("profile likelihood has no meaning"));
  const double moved = std::abs(robust.value(FitParameter::mu1) - reference.value(FitParameter::mu1));
  EXPECT_LT(moved, 0.35 * pulled);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(robust.parameters[i].sd, 0.6 * reference.parameters[i].sd);
    EXPECT_LT(robust.parameters[i].sd, 2.5 * reference.parameters[i].sd);
  }
  ASSERT_EQ(robust.outliers.size(), 1U);
  EXPECT_EQ(robust.outliers[0].run, bad.summary_runs[4].name);
}

TEST(Outliers, AMislabelledRunIsNamedWithThePhiItLooksLike) {
  std::mt19937 random(21);
  Problem problem = noisy({}, random);
  problem.summary_runs[3].name = "swapped";
  problem.summary_runs[3].scenario.friction.phase = 3 * pi / 4 + pi / 2;  // it was filmed at 3 pi/4
  const FitResult result = estimate(problem, quick());
  ASSERT_EQ(result.outliers.size(), 1U);
  const Outlier& outlier = result.outliers[0];
  EXPECT_EQ(outlier.run, "swapped");
  EXPECT_GT(outlier.deviation, 5);
  ASSERT_TRUE(outlier.looks_like_phi);
  EXPECT_NEAR(*outlier.looks_like_phi, 3 * pi / 4, 0.25);
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("it moved as if phi were")));
}

TEST(Outliers, GoodDataHaveNone) {
  int named = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    FitOptions options = quick();
    options.multi_starts = 1;
    named += estimate(noisy({}, random), options).outliers.empty() ? 0 : 1;
  }
  EXPECT_LE(named, 2);  // one in a hundred fits names one; P(> 2 of 20) = 0.001
}

// Deletion: the deviation reported is that of the fit without the run.
TEST(Outliers, TheDropInChiSquareIsThatOfLeavingTheRunOut) {
  std::mt19937 random(5);
  Problem problem = noisy({}, random);
  problem.summary_runs[6].measured.vector += Eigen::Vector2d(3e-4, 1e-4);
  FitOptions options = quick();
  options.estimate_scatter = false;
  const FitResult with = estimate(problem, options);
  ASSERT_FALSE(with.outliers.empty());
  problem.summary_runs.erase(problem.summary_runs.begin() + 6);
  const FitResult without = estimate(problem, options);
  const double spread = std::max(1.0, without.chi2 / without.dof);
  EXPECT_NEAR(with.outliers[0].deviation, std::sqrt((with.chi2 - without.chi2) / spread),
              0.03 * with.outliers[0].deviation);
}

TEST(Bootstrap, AgreesWithTheOtherIntervalsWhereAllAreGaussian) {
  std::mt19937 random(8);
  const Problem problem = noisy({}, random);
  FitOptions options = quick();
  options.bootstrap = 400;
  options.bootstrap_seed = 99;
  options.profiles = true;
  const FitResult result = estimate(problem, options);
  EXPECT_EQ(result.bootstrap.seed, 99U);
  EXPECT_GE(result.bootstrap.refits, 395);
  for (const auto& p : result.parameters) {
    // Ends of 400 draws are uncertain by about 0.13 sd.
    EXPECT_NEAR(p.bootstrap_ci95.low, p.profile_ci95.low, 0.5 * p.sd);
    EXPECT_NEAR(p.bootstrap_ci95.high, p.profile_ci95.high, 0.5 * p.sd);
  }
  EXPECT_THAT(result.full_report(), HasSubstr("95 % bootstrap"));
  EXPECT_THAT(result.full_report(), HasSubstr("refits to simulated data, seed 99"));
  FitOptions threads = options;
  threads.threads = 3;
  EXPECT_EQ(estimate(problem, threads).full_report(), result.full_report());
}

}  // namespace
}  // namespace tribotrack::fit
