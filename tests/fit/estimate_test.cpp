#include "fit/estimate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "fit/campaign.h"

namespace tribotrack::fit {
namespace {

using test::Truth;
using testing::HasSubstr;
constexpr double pi = std::numbers::pi;
const std::vector<FitParameter> kThree{FitParameter::mu1, FitParameter::mu2, FitParameter::lag};

Problem exact_problem(const std::vector<model::Scenario>& scenarios) {
  return test::problem_of(scenarios, 0.01, 0.05e-3);
}

std::string all(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  return text;
}

// Runs that slide throughout, and runs that stick at times.
TEST(Estimate, RecoversTheTruthFromExactDataWithoutAnyGuess) {
  for (const auto& [truth, near] : {std::pair{Truth{}, 1e-7}, {Truth{0.122, 0.02, -0.4}, 1e-6}}) {
    const FitResult result = estimate(exact_problem(test::fourteen(truth)));
    EXPECT_TRUE(result.usable());
    EXPECT_NEAR(result.value(FitParameter::mu1), truth.mu1, near);
    EXPECT_NEAR(result.value(FitParameter::mu2), truth.mu2, near);
    EXPECT_NEAR(result.value(FitParameter::lag), truth.lag, 10 * near);
  }
  const FitResult result = estimate(exact_problem(test::fourteen({})));
  EXPECT_LT(result.chi2, 1e-6);
  EXPECT_EQ(result.dof, 25);
  EXPECT_EQ(result.scatter, 0);
  ASSERT_TRUE(result.next_experiment);
  EXPECT_EQ(result.parameters.size(), 3U);
  for (const auto& p : result.parameters) {
    // Nearly Gaussian here, so both intervals agree.
    EXPECT_NEAR(p.profile_ci95.low, p.ci95.low, 0.1 * p.sd);
    EXPECT_NEAR(p.profile_ci95.high, p.ci95.high, 0.1 * p.sd);
    EXPECT_LT(result.next_experiment->predicted_sd.at(p.parameter), p.sd);
  }
}

/// lag + w delay moves the pulses: two w tell both.
Problem lag_and_delay(const std::vector<double>& frequencies, double lag, double delay) {
  Problem problem;
  problem.free = {FitParameter::lag, FitParameter::delay};
  problem.fixed = {{FitParameter::mu1, 0.1}, {FitParameter::mu2, 0.0125}};
  for (const double w : frequencies)
    for (const double phi : {0.0, 2.0}) {
      model::Scenario s = test::scenario({0.1, 0.0125, lag + w * delay}, phi, pi / 3);
      s.drive.angular_frequency = w;
      s.drive.amplitude = s.drive.amplitude_y = 0.28e-3 * std::pow(62.8 / w, 2);
      problem.summary_runs.push_back(test::summary_run(s, 0.01, 0.05e-3));
    }
  return problem;
}

TEST(Estimate, LagAndDelayAreToldApartByTwoFrequencies) {
  FitOptions options{.profiles = false};
  const FitResult both = estimate(lag_and_delay({62.8, 45.0}, 0.15, 2e-3), options);
  EXPECT_TRUE(both.usable());
  EXPECT_NEAR(both.value(FitParameter::lag), 0.15, 1e-5);
  EXPECT_NEAR(both.value(FitParameter::delay), 2e-3, 1e-7);
}

TEST(Estimate, LagAndDelayAtOneFrequencyAreOneParameter) {
  Problem problem = exact_problem(test::fourteen({}));
  problem.summary_runs.erase(problem.summary_runs.begin() + 1, problem.summary_runs.begin() + 7);
  problem.free.push_back(FitParameter::delay);
  const FitResult result = estimate(problem);
  EXPECT_EQ(result.identifiability.verdict, Verdict::not_identifiable);
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(all(result.identifiability.weak_directions), HasSubstr("is hidden by"));
  EXPECT_TRUE(std::isinf(result.parameters[2].sd));
  EXPECT_TRUE(std::isinf(result.parameters[3].ci95.high));
  EXPECT_TRUE(std::isfinite(result.parameters[0].sd));
  EXPECT_NEAR(result.value(FitParameter::mu1), 0.1, 1e-6);
  // lag + w delay is what the data know.
  EXPECT_NEAR(result.value(FitParameter::lag) + 62.8 * result.value(FitParameter::delay), 0.1, 1e-5);
}

TEST(Estimate, WithoutPulsesMu2AndLagAreDead) {
  Problem problem;
  problem.free = kThree;
  for (const double cycles : {4.0, 9.5}) {
    model::Scenario s = test::scenario({}, 0, 0, cycles);
    problem.summary_runs.push_back(test::summary_run(s, 0.01, 0.01e-3));
    problem.summary_runs.back().scenario = s;
  }
  const FitResult result = estimate(problem);
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(all(result.identifiability.weak_directions),
              HasSubstr("mu2 moves no observable: no run has a pulse"));
}

TEST(Estimate, FixedValuesAndPriorsAreUsed) {
  Problem problem = exact_problem(test::fourteen({}));
  problem.summary_runs.resize(8);
  FitOptions options{.multi_starts = 2, .profiles = false};
  const double alone = estimate(problem, options).parameters[0].sd;

  // The prior enters as one more datum: information adds.
  problem.prior[FitParameter::lag] = {0.1, 0.01};
  const FitResult with_prior = estimate(problem, options);
  const Problem without = [&] {
    Problem p = problem;
    p.prior.clear();
    return p;
  }();
  const FitResult base = estimate(without, options);
  Eigen::MatrixXd information = base.covariance.inverse();
  information(2, 2) += 1 / (0.01 * 0.01);
  const Eigen::MatrixXd expected = information.inverse();
  EXPECT_NEAR(with_prior.parameters[0].sd, std::sqrt(expected(0, 0)), 1e-4 * expected(0, 0) / alone + 1e-7);
  EXPECT_LT(with_prior.parameters[0].sd, 0.5 * alone);
  EXPECT_EQ(with_prior.dof, base.dof + 1);

  problem.prior.clear();
  problem.free = {FitParameter::mu2, FitParameter::lag};
  problem.fixed[FitParameter::mu1] = 0.1;
  const FitResult two = estimate(problem, options);
  EXPECT_NEAR(two.value(FitParameter::mu2), 0.0125, 1e-6);
  EXPECT_THROW(two.value(FitParameter::mu1), DataError);
}

TEST(Estimate, TheScalesUncertaintyEntersTheCovariance) {
  Problem problem = exact_problem(test::fourteen({}));
  FitOptions options{.multi_starts = 2, .profiles = false};
  const FitResult sharp = estimate(problem, options);
  problem.conditions = {{FitParameter::scale, 0.02, "test"}};
  const FitResult blurred = estimate(problem, options);
  EXPECT_EQ(blurred.parameters.size(), 3U);
  EXPECT_GT(blurred.parameters[1].sd, 1.3 * sharp.parameters[1].sd);
  // With A measured in the same picture too, lengths cancel but for mu g: d ln mu = d ln scale at least.
  for (auto& run : problem.summary_runs) run.amplitude_from_track = true;
  const FitResult own = estimate(problem, options);
  EXPECT_NEAR(own.parameters[0].sd / 0.1, std::hypot(0.02, sharp.parameters[0].sd / 0.1), 2e-4);
  EXPECT_NEAR(own.value(FitParameter::mu1), 0.1, 1e-6);
}

TEST(Estimate, RefusesWhatCannotBeFitted) {
  Problem good;
  good.free = kThree;
  for (int k = 0; k < 3; ++k) {
    SummaryRun run;
    run.name = "r" + std::to_string(k);
    run.scenario = test::scenario({}, k, 1);
    run.measured = displacement_from_alpha_v({1, 0.01}, {1e-3, 1e-5}, 62.8, 20);
    good.summary_runs.push_back(run);
  }
  const auto refusal = [&](const std::function<void(Problem&)>& damage) {
    Problem bad = good;
    damage(bad);
    return [bad] { estimate(bad); };
  };
  for (const auto& [damage, text] : std::vector<std::pair<std::function<void(Problem&)>, const char*>>{
           {[](Problem& p) { p.free.clear(); }, "Nothing to fit"},
           {[](Problem& p) { p.summary_runs.clear(); }, "No run"},
           {[](Problem& p) { p.free = {FitParameter::mu1}; }, "No value for mu2"},
           {[](Problem& p) { p.fixed[FitParameter::mu1] = 0.1; }, "both fitted and fixed"},
           {[](Problem& p) { p.free.push_back(FitParameter::mu1); }, "stands twice"},
           {[](Problem& p) {
              p.prior[FitParameter::mu1] = {0.1, 0};
            },
            "sd must be positive"},
           {[](Problem& p) { p.start[FitParameter::mu1] = -0.1; }, "fit.guess mu1"},
           {[](Problem& p) { p.summary_runs[1].measured.covariance.setZero(); }, "Run 'r1'"}})
    EXPECT_THAT(refusal(damage), testing::ThrowsMessage<DataError>(HasSubstr(text)));
  EXPECT_THROW(refusal([](Problem& p) { p.summary_runs[1].scenario.friction.pulse_width = 7; })(),
               model::InvalidParameter);
}

}  // namespace
}  // namespace tribotrack::fit
