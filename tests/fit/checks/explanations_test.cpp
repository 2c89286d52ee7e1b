// Campaigns from a laboratory that is not the model: what is wrong with it is named, and where nothing is,
// nothing is accused.
#include "fit/checks/explanations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "apps/bench/laboratory.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

using bench::AlphaVErrors;
using bench::campaign_of;
using bench::Dice;
using bench::Laboratory;
using testing::HasSubstr;

constexpr AlphaVErrors kGoodCamera{0.002, 0.002};

const FitOptions kQuick{.multi_starts = 4, .profiles = false, .next_experiment = false};

FitResult fitted(const Laboratory& lab, unsigned seed, const std::vector<Condition>& conditions = {},
                 const AlphaVErrors& errors = kGoodCamera) {
  Dice dice(seed, 0, 0);
  Problem problem = campaign_of(lab, errors, dice);
  problem.conditions = conditions;
  return estimate(problem, kQuick);
}

bool holds(const FitResult& result, FitParameter parameter, double truth) {
  for (const ParameterEstimate& p : result.parameters)
    if (p.parameter == parameter) return p.ci95.low <= truth && truth <= p.ci95.high;
  return false;
}

struct Cause {
  const char* name;
  Laboratory lab;
};

class Causes : public testing::TestWithParam<Cause> {};

TEST_P(Causes, AreNamedAndTheValuesQuotedUnderThem) {
  const FitResult result = fitted(GetParam().lab, 5);
  EXPECT_LT(result.p_value, 1e-3);
  const auto named = std::ranges::find(result.explanations, GetParam().name, &Explanation::name);
  ASSERT_NE(named, result.explanations.end());
  EXPECT_TRUE(named->explains) << result.full_report();
  // Another that explains as well may stand before it: then the intervals cover both.
  EXPECT_LT(result.explanations.front().chi2_fall - named->chi2_fall, 6) << result.full_report();
  EXPECT_EQ(result.verdict, Use::care);
  ASSERT_EQ(result.quoted_under.size(), 1U);
  EXPECT_TRUE(holds(result, FitParameter::mu1, GetParam().lab.mu1)) << result.full_report();
  EXPECT_EQ(result.as_assumed.size(), 3U);
  EXPECT_GT(std::abs(result.as_assumed.at(FitParameter::mu1).estimate - GetParam().lab.mu1) +
                std::abs(result.as_assumed.at(FitParameter::mu2).estimate - GetParam().lab.mu2),
            1e-5);
  // mu against speed, as the law has it at rest and at the platform's speed.
  const Laboratory& lab = GetParam().lab;
  if (lab.stribeck == 0) return;
  ASSERT_FALSE(result.mu_of_speed.empty());
  const FrictionAtSpeed &slow = result.mu_of_speed.front(), &fast = result.mu_of_speed.back();
  EXPECT_EQ(slow.speed, 0);
  EXPECT_NEAR(slow.mu, lab.mu1 * (1 + lab.stribeck), 4 * slow.sd);
  EXPECT_NEAR(fast.mu, lab.mu1 * (1 + lab.stribeck * std::exp(-std::pow(lab.fading, -2))), 4 * fast.sd);
  EXPECT_LT(slow.sd, 0.1 * slow.mu);
}

INSTANTIATE_TEST_SUITE_P(Explanations, Causes,
                         testing::Values(Cause{"tilt", {.tilt_x = 8e-4, .tilt_y = -6e-4}},
                                         Cause{"amplitude_ratio", {.ratio = 1.03}},
                                         Cause{"phase_shift", {.epsilon_error = -0.035}},
                                         Cause{"stribeck", {.stribeck = 0.2}},
                                         Cause{"stribeck", {.mu1 = 0.08, .stribeck = 0.3, .fading = 0.45}},
                                         Cause{"viscous", {.viscous = 2}}, Cause{"bad_run", {.bad_run = 3}}),
                         [](const auto& cause) { return cause.param.name + std::to_string(cause.index); });

// Whichever of two unequal amplitudes was given.
TEST(Explanations, IntervalsUnderUnequalAmplitudesHoldWhicheverIsTheOneGiven) {
  for (const double ratio : {0.9, 1.1})
    for (const double given : {std::sqrt(ratio), 1 / std::sqrt(ratio)}) {
      Dice dice(5, 0, 0);
      const Laboratory lab{.ratio = ratio};
      Problem problem = campaign_of(lab, kGoodCamera, dice);
      for (SummaryRun& run : problem.summary_runs)
        run.scenario.drive.amplitude *= given, run.scenario.drive.amplitude_y *= given;
      const FitResult result = estimate(problem, kQuick);
      EXPECT_EQ(result.explanations.front().name, "amplitude_ratio");
      EXPECT_EQ(result.verdict, Use::care);
      EXPECT_TRUE(holds(result, FitParameter::mu1, lab.mu1)) << given << result.full_report();
      EXPECT_TRUE(holds(result, FitParameter::mu2, lab.mu2)) << given << result.full_report();
    }
}

TEST(Explanations, APriorThatContradictsTheDataIsNamed) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    Dice dice(seed, 0, 0);
    Problem problem = campaign_of({}, kGoodCamera, dice);
    problem.prior[FitParameter::mu1] = {0.1 + 0.0005 * seed, 0.001};
    EXPECT_TRUE(estimate(problem, kQuick).contradicted_priors.empty()) << seed;
    problem.prior[FitParameter::mu1] = {0.1, 0.01};
    problem.prior[FitParameter::lag] = {Laboratory().lag + 0.2, 0.02};
    const FitResult result = estimate(problem, kQuick);
    ASSERT_EQ(result.contradicted_priors.size(), 1U) << seed;
    EXPECT_THAT(result.contradicted_priors.front(), HasSubstr("the prior of phase_lag_rad"));
    EXPECT_NE(result.verdict, Use::use);
  }
}

// A minimum that one run has pulled far away is no place from which the others' own is found by descent.
TEST(Explanations, ABadRunIsNamedWhereThePartSticks) {
  int held = 0;
  for (int bad = 0; bad < 14; bad += 2) {
    const Laboratory lab{.mu1 = 0.128, .mu2 = 0.016, .lag = -0.13, .bad_run = bad};
    const FitResult result = fitted(lab, 21 + static_cast<unsigned>(bad));
    EXPECT_LT(result.p_value, 1e-3);
    EXPECT_EQ(result.explanations.front().name, "bad_run") << result.full_report();
    EXPECT_TRUE(result.explanations.front().explains) << bad << result.full_report();
    EXPECT_EQ(result.verdict, Use::care) << bad;
    held += holds(result, FitParameter::mu1, lab.mu1);
  }
  EXPECT_GE(held, 5);  // of 7
}

TEST(Explanations, APerfectLaboratoryIsAccusedOfNothing) {
  int accused = 0;
  for (unsigned seed = 0; seed < 6; ++seed) {
    const FitResult result = fitted({}, 100 + seed);
    accused += result.verdict != Use::use;
    for (const Explanation& explanation : result.explanations) {
      EXPECT_FALSE(explanation.explains);
      EXPECT_FALSE(explanation.refitted);
    }
  }
  EXPECT_EQ(accused, 0);
}

// What is known to an sd is an unknown of the fit: within it nothing is rejected, far beyond it is named.
TEST(Explanations, AConditionWithAnSdExplainsItself) {
  const std::vector<Condition> level = {{FitParameter::tilt_x, 2e-3, "level"},
                                        {FitParameter::tilt_y, 2e-3, "level"}};
  const FitResult within = fitted({.tilt_x = 1e-3}, 7, level);
  EXPECT_EQ(within.verdict, Use::use) << within.full_report();
  EXPECT_TRUE(holds(within, FitParameter::mu1, 0.1));
  const std::vector<Condition> tight = {{FitParameter::tilt_x, 5e-5, "level"},
                                        {FitParameter::tilt_y, 5e-5, "level"}};
  const FitResult beyond = fitted({.tilt_x = 1e-3}, 7, tight);
  EXPECT_EQ(beyond.explanations.front().name, "tilt") << beyond.full_report();
  EXPECT_NEAR(beyond.explanations.front().size, 1e-3, 2e-4);
}

// Displacements are linear in the conditions near what is known of them alone: with small errors a search
// that rests on it ends in another valley.
TEST(Explanations, ConditionsFarFromWhatIsKnownAreFound) {
  const std::vector<Condition> conditions = {{FitParameter::tilt_x, 2e-3, "level"},
                                             {FitParameter::tilt_y, 2e-3, "level"},
                                             {FitParameter::amplitude_ratio, 0.01, "typed"},
                                             {FitParameter::phase_shift, 0.0175, "typed"},
                                             {FitParameter::viscous, 1, "law"},
                                             {FitParameter::stribeck, 0.1, "law"}};
  for (unsigned seed = 30; seed < 38; ++seed) {
    const double turn = seed;
    const Laboratory lab{.mu1 = 0.07 + 0.005 * (seed % 4),
                         .lag = -0.2,
                         .tilt_x = 8e-3 * std::cos(turn),
                         .tilt_y = 8e-3 * std::sin(turn)};
    const FitResult result = fitted(lab, seed, conditions);
    EXPECT_GT(result.p_value, 1e-3) << result.full_report();
    EXPECT_NEAR(result.value(FitParameter::mu1), lab.mu1, 4 * result.parameters[0].sd);
  }
}

FitResult fitted_as_typed(const Laboratory& lab, unsigned seed) {
  Dice dice(seed, 0, 0);
  Problem problem = campaign_of(lab, kGoodCamera, dice);
  bench::take_nothing_as_exact(problem);
  return estimate(problem, kQuick);
}

// A part that friction at rest holds for most of a turn: what the law adds changes with mu as fast as the
// rest, and a search that takes it for constant ends where nothing explains the data.
TEST(Explanations, ALawFarFromWhatIsKnownIsFoundWhereThePartSticks) {
  for (const Laboratory& lab : {Laboratory{.mu1 = 0.1136, .mu2 = 0.0148, .lag = 0.16, .stribeck = 0.45},
                                Laboratory{.mu1 = 0.1157, .mu2 = 0.0151, .lag = -0.41, .stribeck = 0.35}}) {
    const FitResult result = fitted_as_typed(lab, 40);
    EXPECT_GT(result.p_value, 1e-3) << result.full_report();
    EXPECT_NEAR(result.value(FitParameter::mu1), lab.mu1, 4 * result.parameters[0].sd);
  }
}

// With all conditions free to help, a bad run takes the minimum so far that others look worse there.
TEST(Explanations, ABadRunIsNamedWhateverConditionsMakeOfIt) {
  for (const unsigned seed : {60, 61}) {
    const Laboratory lab{.mu1 = 0.101, .mu2 = 0.0231, .lag = -0.342, .bad_run = 7};
    const FitResult result = fitted_as_typed(lab, seed);
    EXPECT_LT(result.p_value, 1e-3);
    EXPECT_EQ(result.explanations.front().run, "run7") << result.full_report();
    EXPECT_EQ(result.verdict, Use::care);
    EXPECT_NEAR(result.value(FitParameter::mu1), lab.mu1, 4 * result.parameters[0].sd);
  }
}

// To first order, without a refit: by how much the truth lies beside what is known to an sd, with its sign.
TEST(Explanations, TheSizeOfAConditionHasTheSignOfItsChange) {
  for (const double off : {0.01, -0.01}) {
    const FitResult result = fitted({.ratio = 1 + off}, 7, {{FitParameter::amplitude_ratio, 3e-3, "typed"}});
    const auto found = std::ranges::find(result.explanations, "amplitude_ratio", &Explanation::name);
    ASSERT_NE(found, result.explanations.end());
    EXPECT_FALSE(found->refitted);
    EXPECT_NEAR(found->size, 100 * off, 0.4) << result.full_report();
  }
}

// By a good camera and by one for which so much friction is far from a first order.
TEST(Explanations, FrictionThatDiffersFromRunToRunIsFoundAndCounted) {
  for (const double sd : {0.002, 1e-4})
    for (const unsigned seed : {9, 10, 11}) {
      const FitResult result = fitted({.scatter = 0.02}, seed, {}, {sd, sd});
      EXPECT_EQ(result.explanations.front().name, "run_scatter") << result.full_report();
      EXPECT_NEAR(result.explanations.front().size, 2, 1.5);
      EXPECT_EQ(result.verdict, Use::care);
      EXPECT_TRUE(holds(result, FitParameter::mu1, 0.1));
    }
}

TEST(HeldOut, RunsArePredictedByTheFitToTheOthers) {
  for (const int bad : {-1, 3}) {
    Dice dice(12, 0, 0);
    Problem problem = campaign_of({.bad_run = bad}, kGoodCamera, dice), without = problem;
    problem.summary_runs[3].held_out = true;
    without.summary_runs.erase(without.summary_runs.begin() + 3);
    const FitResult result = estimate(problem, kQuick), fewer = estimate(without, kQuick);
    EXPECT_EQ(result.dof, fewer.dof);
    EXPECT_NEAR(result.value(FitParameter::mu1), fewer.value(FitParameter::mu1),
                1e-3 * fewer.parameters[0].sd);
    ASSERT_TRUE(result.runs[3].prediction);
    EXPECT_FALSE(result.runs[4].prediction);
    EXPECT_EQ(result.runs[3].prediction->p_value < 1e-6, bad == 3) << result.runs[3].prediction->p_value;
    // The fit's own error is part of it.
    EXPECT_GT(result.runs[3].residuals[0].sd,
              1e3 * std::sqrt(problem.summary_runs[3].measured.covariance(0, 0)));
    EXPECT_EQ(result.verdict, Use::use) << result.full_report();
  }
}

TEST(Explanations, TwoCausesTogetherAreNotPassedOver) {
  const FitResult result = fitted({.tilt_x = 1e-3, .stribeck = 0.2}, 11);
  EXPECT_NE(result.verdict, Use::use);
  EXPECT_LT(result.p_value, 1e-3);
  EXPECT_THAT(result.verdict_text(), HasSubstr("the data reject the model as described"));
}

}  // namespace
}  // namespace tribotrack::fit
