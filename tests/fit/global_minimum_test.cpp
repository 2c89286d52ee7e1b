// The fit finds the global minimum, which looking everywhere knows.
#include <gtest/gtest.h>

#include "apps/bench/campaigns.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

/// The least chi^2 of 40 campaigns of 3 to 14 runs at random, by looking everywhere: descents from all lowest
/// points of a grid over the whole box, from around the best end, and a compass search.
constexpr double kLeast[] = {3.06986,  6.10482,  3.10502,  17.49523, 9.00816,  12.90814, 9.15321,  17.56940,
                             14.80874, 19.37004, 22.08307, 14.94625, 1.67561,  8.91867,  5.81362,  7.58037,
                             6.27314,  12.79902, 11.69978, 8.65791,  11.69818, 15.37695, 38.50122, 15.94962,
                             6.28536,  8.07379,  7.62437,  5.36366,  15.60372, 10.53089, 9.52629,  14.49043,
                             15.56642, 17.07789, 15.57306, 22.54216, 3.62779,  2.69837,  8.05453,  4.28286};

void expect_least_chi2(int index) {
  FitOptions search_alone;
  search_alone.profiles = search_alone.next_experiment = search_alone.estimate_scatter = false;
  const auto level = index / 12 % 2 == 0 ? bench::NoiseLevel::low : bench::NoiseLevel::high;
  const Problem problem = bench::draw_random_runs(3 + index % 12, level, 20210702, index).problem;
  EXPECT_NEAR(estimate(problem, search_alone).chi2, kLeast[index], 0.01) << "campaign " << index;
}

TEST(Search, FindsTheGlobalMinimumOfFewAndOfManyRuns) {
  for (const int index : {0, 10, 13, 23}) expect_least_chi2(index);
}

TEST(SearchCampaign, DISABLED_FindsTheGlobalMinimumOfFortyCampaigns) {
  for (int index = 0; index < static_cast<int>(std::size(kLeast)); ++index) expect_least_chi2(index);
}

}  // namespace
}  // namespace tribotrack::fit
