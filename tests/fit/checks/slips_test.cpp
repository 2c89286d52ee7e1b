// What was typed wrongly is found, and nothing else is accused.
#include "fit/slips.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

using What = SlipFound::What;
constexpr double pi = std::numbers::pi;

const FitOptions kQuick{.multi_starts = 4, .profiles = false, .next_experiment = false};

/// Fourteen runs at 1 deg and 2 %, as a table holds them.
const Problem& table() {
  static std::mt19937 random(3);
  static const Problem problem = test::problem_of(test::fourteen({}), 0.0175, 4e-5, &random);
  return problem;
}

const Typed kTable{.amplitude = true, .frequency = true, .timing = true, .directions = true};

std::vector<SlipFound> found_in(const Problem& problem, const Typed& typed = kTable) {
  return find_slips(problem, estimate(problem, kQuick), typed);
}

/// Of a fit that chi^2 rejects, which is all that is looked at of it.
std::vector<SlipFound> found_in_failing(const Problem& problem) {
  FitResult rejected;
  rejected.converged = true;
  rejected.p_value = 0;
  return find_slips(problem, rejected, kTable);
}

bool names(const std::vector<SlipFound>& found, What what, double factor) {
  return std::ranges::any_of(found, [&](const SlipFound& slip) {
    return slip.what == what && std::abs(slip.factor - factor) <= 1e-9 * std::abs(factor);
  });
}

TEST(Slips, ASoundFitHasNone) {
  EXPECT_TRUE(found_in(table()).empty());
}

TEST(Slips, PeakToPeakIsHalfOfIt) {
  Problem problem = table();
  for (SummaryRun& run : problem.summary_runs)
    run.scenario.drive.amplitude *= 2, run.scenario.drive.amplitude_y *= 2;
  const auto found = found_in_failing(problem);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].what, What::amplitude);
  EXPECT_EQ(found[0].factor, 0.5);
  EXPECT_GT(found[0].p_value, 0.01);
  EXPECT_NEAR(found[0].values.at(FitParameter::mu1), 0.1, 0.004);
}

TEST(Slips, RevolutionsGivenAsRadians) {
  Problem problem = table();
  for (SummaryRun& run : problem.summary_runs) {
    run.scenario.drive.angular_frequency /= 2 * pi;
    run.measured.vector *= 2 * pi;
    run.measured.covariance *= 4 * pi * pi;
    run.measured.duration *= 2 * pi;
  }
  EXPECT_TRUE(names(found_in_failing(problem), What::frequency, 2 * pi));
}

TEST(Slips, YDownwards) {
  Problem problem = table();
  for (SummaryRun& run : problem.summary_runs) run.scenario.drive.phase_shift = -pi / 2;
  EXPECT_TRUE(names(found_in_failing(problem), What::alpha_mirrored, -1));
}

// Where mu1 exceeds what the drive slides the part rests between pulses: chi^2 has valleys of its own there.
TEST(Slips, YDownwardsOfAPartThatRestsBetweenPulses) {
  for (const test::Truth& truth : {test::Truth{0.144, 0.0755, 0.31}, test::Truth{0.13, 0.0727, 0.465}}) {
    Problem problem = test::problem_of(test::fourteen(truth), 0.0175, 4e-5);
    for (SummaryRun& run : problem.summary_runs) run.scenario.drive.phase_shift = -pi / 2;
    EXPECT_TRUE(names(found_in_failing(problem), What::alpha_mirrored, -1)) << truth.mu1;
  }
}

TEST(Slips, ExplainARejectedFitAlone) {
  Problem problem = table();
  for (SummaryRun& run : problem.summary_runs) run.scenario.drive.tilt_x = 0.02;
  FitOptions options = kQuick;
  EXPECT_FALSE(estimate(problem, options).explanations.empty());
  options.mistyped = [](const FitResult& assumed) { return assumed.p_value < 1e-3; };
  const FitResult result = estimate(problem, options);
  EXPECT_TRUE(result.mistyped);
  EXPECT_TRUE(result.explanations.empty());
  EXPECT_EQ(result.verdict, Use::do_not_use);
}

TEST(Slips, PhiCountedToAnotherEdgeOfThePulse) {
  const auto found_in_phi = [](double sense, double share) {
    Problem problem = table();
    for (SummaryRun& run : problem.summary_runs) {
      model::Friction& friction = run.scenario.friction;
      friction.phase = sense * (friction.phase + share * friction.pulse_width);
    }
    return found_in_failing(problem);
  };
  EXPECT_TRUE(names(found_in_phi(1, 0.5), What::phi_edge, -0.5));
  EXPECT_TRUE(names(found_in_phi(1, 1), What::phi_edge, -1));
  EXPECT_TRUE(names(found_in_phi(-1, 0), What::phi_reversed, 0));
  EXPECT_TRUE(names(found_in_phi(-1, 1), What::phi_reversed, -1));
}

TEST(Slips, RadiansInAColumnOfDegrees) {
  Problem problem = table();
  for (SummaryRun& run : problem.summary_runs) run.scenario.friction.phase *= pi / 180;
  EXPECT_TRUE(names(found_in_failing(problem), What::phi, 180 / pi));
}

// Where A was seen at the same scale friction scales with it, and chi^2 tells nothing.
TEST(Slips, AScaleTenTimesTooLargeIsAbsurd) {
  Problem problem = table();
  for (SummaryRun& run : problem.summary_runs) {
    run.measured.given_as_velocity = false;
    run.amplitude_from_track = true;
    run.measured.vector *= 10;
    run.measured.covariance *= 100;
    run.scenario.drive.amplitude *= 10;
    run.scenario.drive.amplitude_y *= 10;
  }
  const auto found = found_in(problem, {.timing = true, .lengths = true});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].what, What::lengths);
  EXPECT_EQ(found[0].factor, 0.1);
  EXPECT_NEAR(found[0].values.at(FitParameter::mu1), 0.1, 0.004);
}

}  // namespace
}  // namespace tribotrack::fit
