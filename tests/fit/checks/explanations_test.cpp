// Campaigns from a laboratory that is not the model: what is wrong with it is named, and where nothing is,
// nothing is accused.
#include "fit/checks/explanations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "fit/estimate.h"
#include "fit/problem.h"

// A laboratory that is not the model: Moreau's time stepping (J. J. Moreau, Unilateral contact and dry
// friction in finite freedom dynamics, 1988) of a part on a platform that may be tilted, elliptic, or shaken
// out of phase, under friction that may depend on speed and the run.

namespace tribotrack::test {

struct Laboratory {
  double mu1 = 0.1, mu2 = 0.02, lag = 0.2;
  // What the campaign does not say.
  double tilt_x = 0, tilt_y = 0;        ///< rad
  double ratio = 1, epsilon_error = 0;  ///< A_y/A about their mean; rad
  double stribeck = 0, viscous = 0;     ///< relative, fading by A w/4; 1/s
  double scatter = 0;                   ///< relative, of both from run to run
  int bad_run = -1;                     ///< whose phi was 0.7 rad more than it says
};

/// Displacement of one run, m.
inline Eigen::Vector2d stepped(const Laboratory& lab, const model::Scenario& s, double mu1, double mu2) {
  constexpr int kSteps = 1000;  // a turn
  const double w = s.drive.angular_frequency, g = s.drive.gravity, a = s.drive.amplitude;
  const double dt = 2 * std::numbers::pi / w / kSteps, fading = a * w / 4;
  const double on = s.friction.phase + lab.lag, width = s.friction.pulse_width;
  // Integral of the share of mu2 in mu over wt.
  const auto open = [&](double wt) {
    const double turns = std::floor((wt - on) / (2 * std::numbers::pi));
    const double into = wt - on - 2 * std::numbers::pi * turns;
    const auto pulse = [&](double q) { return std::clamp(q, 0.0, width); };
    return turns * width + pulse(into) + pulse(into + 2 * std::numbers::pi) - width;
  };
  Eigen::Vector2d x = Eigen::Vector2d::Zero(), u = x;
  const Eigen::Vector2d pull(g * std::sin(lab.tilt_x), g * std::sin(lab.tilt_y));
  double before = open(0);
  for (int k = 0; k < static_cast<int>(s.cycles) * kSteps; ++k) {
    const double wt = (k + 0.5) * w * dt, after = open((k + 1) * w * dt);
    const double reduced = (after - before) / (w * dt), speed = u.norm();
    before = after;
    const Eigen::Vector2d push =
        pull +
        w * w * a / std::sqrt(lab.ratio) *
            Eigen::Vector2d(std::cos(wt), lab.ratio * std::cos(wt + s.drive.phase_shift + lab.epsilon_error));
    const double mu =
        (mu1 + (mu2 - mu1) * reduced) * (1 + lab.stribeck * std::exp(-speed * speed / (fading * fading))) +
        lab.viscous * speed / g;
    const double most = mu * g * dt;
    const Eigen::Vector2d free = u + dt * push;
    Eigen::Vector2d next =
        free.norm() <= most ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(free * (1 - most / free.norm()));
    if (speed > 2 * most)  // of second order where it slides: along the mean velocity
      for (int i = 0; i < 4; ++i) next = free - most * (0.5 * (u + next)).normalized();
    x += dt * 0.5 * (u + next);
    u = next;
  }
  return x;
}

/// Eight phi at one width, six widths at one phi, in an order of chance; as the campaign believes them.
inline fit::Problem campaign(const Laboratory& lab, double alpha_sd, double v_sd, std::mt19937& random) {
  std::normal_distribution<double> normal;
  fit::Problem problem;
  problem.free = {fit::FitParameter::mu1, fit::FitParameter::mu2, fit::FitParameter::lag};
  for (int k = 0; k < 14; ++k) {
    fit::SummaryRun run;
    run.name = "run" + std::to_string(k);
    model::Scenario& s = run.scenario;
    s.cycles = 20;
    s.friction.phase = k < 8 ? k * std::numbers::pi / 4 : 0;
    s.friction.pulse_width =
        k < 8 ? std::numbers::pi / 3 : (k - 7) * std::numbers::pi / 6 + (k > 8 ? 0.5 : 0);
    model::Scenario truth = s;
    if (k == lab.bad_run) truth.friction.phase += 0.7;
    const double run_factor = 1 + lab.scatter * normal(random);
    const Eigen::Vector2d moved = stepped(lab, truth, lab.mu1 * run_factor, lab.mu2 * run_factor);
    const double duration = s.end_time(), v = moved.norm() / duration;
    run.measured = fit::displacement_from_alpha_v(
        {std::atan2(moved.y(), moved.x()) + alpha_sd * normal(random), alpha_sd},
        {v * (1 + v_sd * normal(random)), v_sd * v}, s.drive.angular_frequency, 20);
    problem.summary_runs.push_back(run);
  }
  return problem;
}

}  // namespace tribotrack::test

namespace tribotrack::fit {
namespace {

using test::campaign;
using test::Laboratory;
using testing::HasSubstr;

constexpr double kAlphaSd = 0.002, kSpeedSd = 0.002;  // of a good camera

const FitOptions kQuick{.multi_starts = 4, .profiles = false, .next_experiment = false};

FitResult fitted(const Laboratory& lab, unsigned seed, const std::vector<Condition>& conditions = {}) {
  std::mt19937 random(seed);
  Problem problem = campaign(lab, kAlphaSd, kSpeedSd, random);
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
  EXPECT_NEAR(fast.mu, lab.mu1, 4 * fast.sd);
  EXPECT_LT(slow.sd, 0.1 * slow.mu);
}

INSTANTIATE_TEST_SUITE_P(Explanations, Causes,
                         testing::Values(Cause{"tilt", {.tilt_x = 8e-4, .tilt_y = -6e-4}},
                                         Cause{"amplitude_ratio", {.ratio = 1.03}},
                                         Cause{"phase_shift", {.epsilon_error = -0.035}},
                                         Cause{"stribeck", {.stribeck = 0.2}},
                                         Cause{"viscous", {.viscous = 2}}, Cause{"bad_run", {.bad_run = 3}}),
                         [](const auto& cause) { return std::string(cause.param.name); });

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

TEST(Explanations, FrictionThatDiffersFromRunToRunIsFoundAndCounted) {
  const FitResult result = fitted({.scatter = 0.02}, 9);
  EXPECT_EQ(result.explanations.front().name, "run_scatter") << result.full_report();
  EXPECT_NEAR(result.explanations.front().size, 2, 1.5);
  EXPECT_EQ(result.verdict, Use::care);
  EXPECT_TRUE(holds(result, FitParameter::mu1, 0.1));
}

TEST(HeldOut, RunsArePredictedByTheFitToTheOthers) {
  for (const int bad : {-1, 3}) {
    std::mt19937 random(12);
    Problem problem = campaign({.bad_run = bad}, kAlphaSd, kSpeedSd, random), without = problem;
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
