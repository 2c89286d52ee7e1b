// Laws of the fit: what a change of its data does to its result, whatever the data are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "apps/bench/fit/bench.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

FitOptions plain() {
  FitOptions options;
  options.multi_starts = 1;
  options.profiles = options.next_experiment = options.estimate_scatter = false;
  return options;
}

/// 14 displacements over 5 cycles, with noise.
Problem campaign() {
  return bench::simulated_campaign({0.1, 0.0125, 0.15}, 17, 5);
}

TEST(FitLaws, TheOrderOfRunsIsIrrelevant) {
  const Problem ordered = campaign();
  Problem reversed = ordered;
  std::ranges::reverse(reversed.summary_runs);
  const FitResult one = estimate(ordered, plain()), other = estimate(reversed, plain());
  ASSERT_EQ(one.parameters.size(), other.parameters.size());
  for (std::size_t k = 0; k < one.parameters.size(); ++k) {
    // Sums in another order: equal but for rounding, which the last step's size (1e-8 sd or so) hides.
    EXPECT_NEAR(one.parameters[k].estimate, other.parameters[k].estimate, 1e-6 * one.parameters[k].sd);
    EXPECT_NEAR(one.parameters[k].sd, other.parameters[k].sd, 1e-6 * one.parameters[k].sd);
  }
  EXPECT_NEAR(one.chi2, other.chi2, 1e-9 * one.chi2);
}

TEST(FitLaws, EveryRunTwiceLeavesTheValuesAndDividesTheirStandardDeviationsByRootTwo) {
  const Problem once = campaign();
  Problem twice = once;
  for (SummaryRun run : once.summary_runs) {
    run.name += " again";
    twice.summary_runs.push_back(run);
  }
  const FitResult one = estimate(once, plain()), two = estimate(twice, plain());
  for (std::size_t k = 0; k < one.parameters.size(); ++k) {
    EXPECT_NEAR(two.parameters[k].estimate, one.parameters[k].estimate, 1e-4 * one.parameters[k].sd);
    EXPECT_NEAR(two.parameters[k].sd, one.parameters[k].sd / std::sqrt(2.0), 1e-5 * one.parameters[k].sd);
  }
  EXPECT_NEAR(two.chi2, 2 * one.chi2, 1e-7 * one.chi2);
}

TEST(FitLaws, AnotherUnitOfLengthChangesNeitherFrictionNorItsStandardDeviation) {
  // Lengths, amplitude and gravity a hundred times as large: the same motion in centimetres, with numbers
  // that the fit takes for metres. mu and lag have no unit.
  const Problem metres = campaign();
  Problem centimetres = metres;
  for (SummaryRun& run : centimetres.summary_runs) {
    run.scenario.drive.amplitude *= 100;
    run.scenario.drive.amplitude_y *= 100;
    run.scenario.drive.gravity *= 100;
    run.measured.vector *= 100;
    run.measured.covariance *= 1e4;
    run.measured.mean_velocity.value *= 100;
    run.measured.mean_velocity.sd *= 100;
  }
  const FitResult one = estimate(metres, plain()), other = estimate(centimetres, plain());
  for (std::size_t k = 0; k < one.parameters.size(); ++k) {
    EXPECT_NEAR(one.parameters[k].estimate, other.parameters[k].estimate, 1e-4 * one.parameters[k].sd);
    EXPECT_NEAR(one.parameters[k].sd, other.parameters[k].sd, 1e-5 * one.parameters[k].sd);
  }
  EXPECT_NEAR(one.chi2, other.chi2, 1e-7 * one.chi2);
}

}  // namespace
}  // namespace tribotrack::fit
