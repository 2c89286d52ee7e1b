#include "fit/goal.h"

#include <gtest/gtest.h>

#include <limits>

namespace tribotrack::fit {
namespace {

FitResult result_with(double mu1, Interval of_mu1, double lag, Interval of_lag) {
  FitResult result;
  result.converged = true;
  result.parameters.resize(2);
  result.parameters[0].parameter = FitParameter::mu1;
  result.parameters[0].estimate = mu1;
  result.parameters[0].ci95 = of_mu1;
  result.parameters[1].parameter = FitParameter::lag;
  result.parameters[1].estimate = lag;
  result.parameters[1].ci95 = of_lag;
  return result;
}

NextExperiment run_with(double dtau, Interval of_mu1, Interval of_lag, double amplitude = 1) {
  NextExperiment next;
  next.dtau = dtau;
  next.amplitude = amplitude;
  next.predicted_ci95 = {{FitParameter::mu1, of_mu1}, {FitParameter::lag, of_lag}};
  return next;
}

const Goal kPercentOfMu1{FitParameter::mu1, 0.01, true};
const Goal kLagTo{FitParameter::lag, 0.02, false};

TEST(Goal, RatioIsHalfTheIntervalOverWhatIsAllowed) {
  const FitResult result = result_with(0.2, {0.19, 0.21}, -0.5, {-0.53, -0.47});
  EXPECT_DOUBLE_EQ(ratio_to(kPercentOfMu1, result), 5);
  EXPECT_NEAR(ratio_to(kLagTo, result), 1.5, 1e-12);
  EXPECT_NEAR(ratio_to({FitParameter::lag, 0.06, true}, result), 1, 1e-12) << "a share of the magnitude";
  EXPECT_THROW(ratio_to({FitParameter::mu2, 1, false}, result), DataError);
}

TEST(Goal, IsReachedWhenAllAre) {
  FitResult result = result_with(0.2, {0.1985, 0.2015}, -0.5, {-0.53, -0.47});
  result.verdict = Use::care;
  EXPECT_TRUE(all_reached({kPercentOfMu1}, result));
  EXPECT_FALSE(all_reached({kPercentOfMu1, kLagTo}, result));
  EXPECT_FALSE(all_reached({}, result)) << "without a goal filming goes on";
  FitResult unusable = result;
  unusable.verdict = Use::do_not_use;
  EXPECT_FALSE(all_reached({kPercentOfMu1}, unusable));
}

TEST(Goal, AnOpenIntervalIsInfinitelyFar) {
  const double open = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ratio_to(kPercentOfMu1, result_with(0.2, {0.1, open}, 0, {-open, open})), open);
}

TEST(Goal, NextIsTheRunThatServesTheWorstGoal) {
  FitResult result = result_with(0.2, {0.19, 0.21}, 0.5, {0.4, 0.6});
  EXPECT_EQ(next_for({kPercentOfMu1}, result), nullptr);
  result.next_experiment = run_with(1, {0.192, 0.208}, {0.45, 0.55});
  result.other_next_experiments = {run_with(2, {0.198, 0.202}, {0.41, 0.59}),  // for mu1
                                   run_with(3, {0.191, 0.209}, {0.49, 0.51}),  // for the lag
                                   run_with(4, {0.199, 0.201}, {0.499, 0.501}, 1.25)};
  EXPECT_EQ(next_for({}, result)->dtau, 1) << "the best for all";
  EXPECT_EQ(next_for({kPercentOfMu1}, result)->dtau, 2);
  EXPECT_EQ(next_for({kLagTo}, result)->dtau, 3) << "the platform keeps its drive";
  EXPECT_EQ(next_for({kPercentOfMu1, {FitParameter::lag, 0.001, false}}, result)->dtau, 3)
      << "the lag is farther off";
}

}  // namespace
}  // namespace tribotrack::fit
