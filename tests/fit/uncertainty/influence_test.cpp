// The influence of a run, to first order, against the fit that leaves it out, and the points of profiles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"
#include "fit/free_slides.h"

namespace tribotrack::fit {
namespace {

/// Fourteen runs with errors of their stated size.
Problem noisy() {
  std::mt19937 random(7);
  return test::problem_of(test::fourteen({}), 0.01, 0.05e-3, &random);
}

FitOptions plain() {
  return {.profiles = false, .next_experiment = false, .estimate_scatter = false};
}

TEST(Influence, IsTheChangeOfTheFitWithoutTheRun) {
  const Problem problem = noisy();
  const FitResult all = estimate(problem, plain());
  double largest = 0;
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
    Problem without = problem;
    without.summary_runs.erase(without.summary_runs.begin() + static_cast<std::ptrdiff_t>(i));
    const FitResult others = estimate(without, plain());
    ASSERT_EQ(all.runs[i].influence.size(), 3u);
    for (std::size_t p = 0; p < 3; ++p) {
      const double change =
          (others.parameters[p].estimate - all.parameters[p].estimate) / all.parameters[p].sd;
      EXPECT_NEAR(all.runs[i].influence[p], change, 0.05 + 0.05 * std::abs(change)) << "run " << i;
      largest = std::max(largest, std::abs(change));
    }
  }
  EXPECT_GT(largest, 0.3) << "no run matters here: this test shows nothing";
}

// Without a slide the prior of its own deviation says nothing either.
TEST(Influence, OfASlideIsThatOfAllItsRows) {
  std::mt19937 random(3);
  const test::UnitSlide straight(0);
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.between_slides = 0.01;
  for (const double mu : {0.16, 0.17, 0.19, 0.172}) {
    test::SlideLook look;
    look.mu = mu;
    problem.trajectory_runs.push_back(test::slide_track(straight, 0, look, random, false));
    problem.trajectory_runs.back().name += std::to_string(problem.trajectory_runs.size());
  }
  const FitResult all = estimate(problem, plain());
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i) {
    Problem without = problem;
    without.trajectory_runs.erase(without.trajectory_runs.begin() + static_cast<std::ptrdiff_t>(i));
    const double change = (estimate(without, plain()).parameters[0].estimate - all.parameters[0].estimate) /
                          all.parameters[0].sd;
    EXPECT_NEAR(all.runs[i].influence[0], change, 0.05 + 0.05 * std::abs(change)) << "slide " << i;
  }
}

TEST(Influence, ARunWithoutWhichNothingIsDeterminedHasNone) {
  Problem problem = noisy();
  problem.summary_runs.resize(2);
  for (const RunResult& run : estimate(problem, plain()).runs)
    for (const double change : run.influence) EXPECT_TRUE(std::isnan(change));
}

TEST(ProfilePoints, ReachFromEndToEndAndRiseAwayFromTheMinimum) {
  FitOptions options = plain();
  options.profiles = true;
  for (const ParameterEstimate& p : estimate(noisy(), options).parameters) {
    ASSERT_GE(p.profile.size(), 3u);
    EXPECT_NEAR(p.profile_level, 3.8415, 1e-3);
    const auto lowest = std::ranges::min_element(p.profile, {}, &ProfilePoint::rise);
    EXPECT_NEAR(lowest->value, p.estimate, 0.02 * p.sd);
    EXPECT_TRUE(
        std::is_sorted(p.profile.begin(), lowest + 1, [](auto a, auto b) { return a.rise > b.rise; }));
    EXPECT_TRUE(std::is_sorted(lowest, p.profile.end(), [](auto a, auto b) { return a.rise < b.rise; }));
    const auto reaches = [&](double end) {
      return std::ranges::any_of(p.profile, [&](const ProfilePoint& point) {
        return std::abs(point.value - end) < 0.02 * p.sd && std::abs(point.rise - p.profile_level) < 0.1;
      });
    };
    EXPECT_TRUE(reaches(p.profile_ci95.low));
    EXPECT_TRUE(reaches(p.profile_ci95.high));
  }
}

}  // namespace
}  // namespace tribotrack::fit
