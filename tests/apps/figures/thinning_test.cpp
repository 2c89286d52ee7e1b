#include "apps/figures/thinning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace tribotrack::apps {
namespace {

using testing::ElementsAre;
using testing::IsNan;

constexpr double gap = std::numeric_limits<double>::quiet_NaN();

TEST(Thinned, AShortPathStaysAsItIs) {
  const DrawnPath path = thinned({1, 2, 3}, {4, 5, 6}, 3);
  EXPECT_THAT(path.x, ElementsAre(1, 2, 3));
  EXPECT_THAT(path.y, ElementsAre(4, 5, 6));
}

TEST(Thinned, EveryKthPointOfALongOne) {
  std::vector<double> x(10);
  std::iota(x.begin(), x.end(), 0);
  EXPECT_THAT(thinned(x, x, 5).x, ElementsAre(0, 2, 4, 6, 8));
  EXPECT_THAT(thinned(x, x, 4).x, ElementsAre(0, 3, 6, 9));
  EXPECT_THAT(thinned(x, x, 1).x, ElementsAre(0));
}

TEST(Thinned, EveryGapStaysAGap) {
  EXPECT_THAT(thinned({0, gap, 2, 3}, {0, 1, 2, 3}, 4).x, ElementsAre(0, IsNan(), 2, 3));
  EXPECT_THAT(thinned({0, 1, 2, 3}, {0, 1, gap, 3}, 4).y, ElementsAre(0, 1, IsNan(), 3));
  EXPECT_THAT(thinned({0, gap, 2, 3}, {0, 1, 2, 3}, 2).x, ElementsAre(0, IsNan(), 2))
      << "between drawn points";
  EXPECT_THAT(thinned({0, 1, gap, 3, 4, 5}, {0, 1, 2, 3, 4, 5}, 3).x, ElementsAre(0, IsNan(), 4))
      << "on a drawn point";
}

TEST(Thinned, NothingGivesNothing) {
  EXPECT_TRUE(thinned({}, {}, 10).x.empty());
}

TEST(Envelope, AShortSeriesStaysAsItIs) {
  EXPECT_THAT(envelope({3, 1, 2}, 3), ElementsAre(0, 1, 2));
}

TEST(Envelope, NoOutlierIsLost) {
  std::vector<double> y(10000, 1.0);
  y[1234] = 7;
  y[5678] = -7;
  y[9999] = 2;
  const std::vector<double> drawn = picked(y, envelope(y, 100));
  EXPECT_LE(drawn.size(), 100u);
  EXPECT_THAT(drawn, testing::Contains(7));
  EXPECT_THAT(drawn, testing::Contains(-7));
  EXPECT_THAT(drawn, testing::Contains(2));
}

TEST(Envelope, PlacesAscendAndGapsStayGaps) {
  std::vector<double> y(1000, 0.5);
  std::fill(y.begin() + 200, y.begin() + 400, gap);
  const std::vector<std::size_t> places = envelope(y, 50);
  EXPECT_TRUE(std::ranges::is_sorted(places));
  EXPECT_THAT(picked(y, places), testing::Contains(IsNan()));
}

}  // namespace
}  // namespace tribotrack::apps
