// The budget: every source is a part of the variance, and all of them are the whole.
#include "fit/uncertainty/budget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

/// `noise`: with errors drawn; without them the refits of a law are linear.
Problem campaign(bool noise) {
  std::mt19937 random(21);
  Problem problem = test::problem_of(test::fourteen({}), 0.02, 0.05e-3, noise ? &random : nullptr);
  const model::Drive& drive = problem.summary_runs.front().scenario.drive;
  using enum FitParameter;
  problem.conditions = {{amplitude, 2e-3 * drive.amplitude, "marker"},
                        {amplitude, 1e-3 * drive.amplitude, "coder"},
                        {amplitude_ratio, 1e-3, "marker"},
                        {angular_frequency, 1e-3 * drive.angular_frequency, "marker"},
                        {phase_shift, 2e-3, "marker"},
                        {phase_reference, 0.01, "sensor"},
                        {gravity, 0.01, "campaign"},
                        {tilt_x, 1e-3, "campaign"}};
  for (SummaryRun& run : problem.summary_runs)
    run.own = {{model::Parameter::phi, model::Parameter::dtau},
               (Eigen::Matrix2d() << 4e-4, 1e-4, 1e-4, 1e-4).finished()};
  return problem;
}

const FitOptions kQuick{.multi_starts = 1, .profiles = false, .next_experiment = false};

TEST(Budget, AddsUpToTheVariance) {
  const FitResult result = estimate(campaign(true), kQuick);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(3);
  std::size_t counted = 0;
  for (const BudgetEntry& entry : result.budget)
    if (entry.counted) sum += entry.contribution.cwiseAbs2(), ++counted;
  EXPECT_GE(counted, 9U);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double sd = result.parameters[static_cast<std::size_t>(i)].sd;
    // Sources of less than a thousandth of every sd are left out.
    EXPECT_NEAR(std::sqrt(sum(i)), sd, 1e-5 * sd);
  }
  EXPECT_FALSE(result.improve_first.empty());
}

TEST(Budget, ImaginesOnePercentOfWhatWasTakenAsExact) {
  Problem problem = campaign(false);
  problem.conditions.clear();
  const FitResult result = estimate(problem, kQuick);
  const auto entry =
      std::ranges::find(result.budget, to_string(FitParameter::amplitude), &BudgetEntry::quantity);
  ASSERT_NE(entry, result.budget.end());
  EXPECT_FALSE(entry->counted);
  const double amplitude = problem.summary_runs.front().scenario.drive.amplitude;
  EXPECT_NEAR(entry->sd, 0.01 * amplitude, 1e-9 * amplitude);
  for (Eigen::Index i = 0; i < 3; ++i)
    EXPECT_NEAR(entry->contribution(i), std::abs(entry->sensitivity(i)) * 0.01 * amplitude,
                1e-9 * entry->contribution(i));
}

/// A sensitivity is what a fit with another value of the quantity finds.
TEST(Budget, SensitivitiesAreThoseOfRefits) {
  const Problem problem = campaign(false);
  const FitResult result = estimate(problem, kQuick);
  const auto entry_of = [&](FitParameter quantity, bool counted) {
    for (const BudgetEntry& entry : result.budget)
      if (entry.quantity == to_string(quantity) && entry.counted == counted) return entry;
    ADD_FAILURE() << to_string(quantity);
    return BudgetEntry{};
  };
  const auto shift_by = [&](const auto& change, double by) {
    Problem more = problem, less = problem;
    for (auto& run : more.summary_runs) change(run.scenario.drive, by);
    for (auto& run : less.summary_runs) change(run.scenario.drive, -by);
    const FitResult up = estimate(more, kQuick), down = estimate(less, kQuick);
    Eigen::Vector3d shift;
    for (std::size_t i = 0; i < 3; ++i)
      shift(static_cast<Eigen::Index>(i)) =
          (up.parameters[i].estimate - down.parameters[i].estimate) / (2 * by);
    return shift;
  };
  const Eigen::Vector3d gravity = shift_by([](auto&drive, double by) { drive.gravity += by; }, 0.02),
                        tilt = shift_by([](auto&drive, double by) { drive.tilt_y += by; }, 1e-4);
  const BudgetEntry known = entry_of(FitParameter::gravity, true),
                    exact = entry_of(FitParameter::tilt_y, false);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double sd = result.parameters[static_cast<std::size_t>(i)].sd;
    EXPECT_NEAR(known.sensitivity(i) * 0.02, gravity(i) * 0.02,
                0.02 * std::abs(gravity(i)) * 0.02 + 1e-3 * sd);
    EXPECT_NEAR(exact.sensitivity(i) * 1e-3, tilt(i) * 1e-3, 0.03 * std::abs(tilt(i)) * 1e-3 + 1e-3 * sd);
  }
}

}  // namespace
}  // namespace tribotrack::fit
