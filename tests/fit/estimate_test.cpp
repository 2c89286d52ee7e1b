#include "fit/estimate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

#include "fit/campaign.h"

namespace tribotrack::fit {
namespace {

using testing::HasSubstr;
using test::Truth;
constexpr double pi = std::numbers::pi;
const std::vector<FitParameter> kThree{FitParameter::mu1, FitParameter::mu2, FitParameter::lag};

Problem exact_problem(const std::vector<model::Scenario>& scenarios) {
  Problem problem;
  problem.free = kThree;
  for (const auto& s : scenarios) problem.summary_runs.push_back(test::summary_run(s, 0.01, 0.05e-3));
  return problem;
}

[[maybe_unused]] std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  return text;
}

TEST(Estimate, RecoversTheTruthFromExactDataWithoutAnyGuess) {
  const Truth truth;
  const Problem problem = exact_problem(test::fourteen(truth));
  const auto begin = std::chrono::steady_clock::now();
  const FitResult result = estimate(problem);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  RecordProperty("seconds", std::to_string(seconds));
  std::printf("%s%.3f s\n", result.full_report().c_str(), seconds);
  EXPECT_TRUE(result.usable());
  EXPECT_NEAR(result.value(FitParameter::mu1), truth.mu1, 1e-7);
  EXPECT_NEAR(result.value(FitParameter::mu2), truth.mu2, 1e-7);
  EXPECT_NEAR(result.value(FitParameter::lag), truth.lag, 1e-6);
  EXPECT_LT(result.chi2, 1e-6);
  EXPECT_EQ(result.dof, 25);
  EXPECT_EQ(result.scatter, 0);
}

}  // namespace
}  // namespace tribotrack::fit
