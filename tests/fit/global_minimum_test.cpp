// The fit finds the global minimum, which looking everywhere knows.
#include <gtest/gtest.h>

#include "apps/bench/coverage.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

/// The least chi^2 of 120 campaigns of 3 to 14 runs at random. Of the first 40 by looking everywhere:
/// descents from all lowest points of a grid over the whole box, from around the best end, and a compass
/// search; of the others from a screen of 8000 points.
constexpr double kLeast[] = {
    3.06986,  6.10482,  3.10502,  17.49523, 9.00816,  12.90814, 9.15321,  17.56940, 14.80874, 19.37004,
    22.08307, 14.94625, 1.67561,  8.91867,  5.81362,  7.58037,  6.27314,  12.79902, 11.69978, 8.65791,
    11.69818, 15.37695, 38.50122, 15.94962, 6.28536,  8.07379,  7.62437,  5.36366,  15.60372, 10.53089,
    9.52629,  14.49043, 15.56642, 17.07789, 15.57306, 22.54216, 3.62779,  2.69837,  8.05453,  4.28286,
    9.81656,  13.21131, 9.76316,  23.10563, 20.72035, 19.29314, 19.82598, 28.38849, 3.89705,  9.34818,
    12.45000, 8.08615,  11.91956, 14.65001, 18.33700, 19.42382, 16.34956, 25.27290, 18.40366, 18.56705,
    0.73154,  7.88456,  9.76412,  5.78720,  4.81050,  16.65089, 12.59390, 23.20693, 19.05228, 19.24754,
    31.54125, 26.94679, 3.10693,  5.72695,  1.60013,  7.31041,  9.57235,  12.58348, 8.85311,  15.19018,
    16.95406, 17.04995, 20.51614, 18.49353, 2.19588,  1.66683,  7.40290,  7.32628,  7.27423,  16.22233,
    14.70229, 18.80770, 17.76197, 12.52291, 19.79327, 23.04775, 1.01624,  5.34863,  11.05909, 7.46872,
    18.34771, 10.12593, 30.76721, 15.47780, 19.07601, 15.81438, 18.38134, 16.89673, 2.03419,  3.34824,
    13.53682, 9.20979,  11.35178, 16.10057, 13.73946, 17.64381, 11.63889, 19.49229, 39.54700, 23.65442};

void expect_least_chi2(int index) {
  FitOptions search_alone{.profiles = false, .next_experiment = false, .estimate_scatter = false};
  const auto level = index / 12 % 2 == 0 ? bench::NoiseLevel::low : bench::NoiseLevel::high;
  const Problem problem = bench::draw_random_runs(3 + index % 12, level, 20210702, index).problem;
  EXPECT_NEAR(estimate(problem, search_alone).chi2, kLeast[index], 0.01) << "campaign " << index;
}

class Search : public testing::TestWithParam<int> {};

TEST_P(Search, FindsTheGlobalMinimumOfFewAndOfManyRuns) {
  for (int k = 0; k < 30; ++k) expect_least_chi2(GetParam() + k);
}

INSTANTIATE_TEST_SUITE_P(Campaigns, Search, testing::Values(0, 30, 60, 90));

}  // namespace
}  // namespace tribotrack::fit
