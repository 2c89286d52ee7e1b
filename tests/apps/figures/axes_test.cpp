#include "apps/figures/axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace tribotrack::apps {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kPi = std::numbers::pi;

TEST(MultipleOfPi, IsReduced) {
  EXPECT_EQ(multiple_of_pi(0, 4), "0");
  EXPECT_EQ(multiple_of_pi(4, 4), "π");
  EXPECT_EQ(multiple_of_pi(-2, 4), "−π/2");
  EXPECT_EQ(multiple_of_pi(10, 12), "5π/6");
}

TEST(AngleAxis, AWholeTurnHasQuarters) {
  EXPECT_THAT(angle_axis("", 0, 2 * kPi).labels,
              ElementsAre("0", "π/4", "π/2", "3π/4", "π", "5π/4", "3π/2", "7π/4", "2π"));
}

TEST(AngleAxis, ValuesOnSixthsHaveThirds) {
  EXPECT_THAT(angle_axis("", 0.4, 3.2, {kPi / 6, kPi / 3, kPi}).labels,
              ElementsAre("π/6", "π/3", "π/2", "2π/3", "5π/6", "π"));
}

// 43 pi / 24 is no sensible tick.
TEST(AngleAxis, ARangeTooShortForTwelfthsHasDecimals) {
  EXPECT_THAT(angle_axis("", 5.6, 5.7).ticks, IsEmpty());
}

TEST(SettleAxes, EndsThatAreGivenStayAndTheOthersHoldTheData) {
  Figure figure{.id = "f", .title = "f", .caption = ""};
  FigurePanel panel{.x = {.low = 0}, .y = {}};
  panel.series = {{.mark = Mark::points, .x = {1, 2}, .y = {-3, 4}, .sd = {1, 1}}};
  figure.panels = {panel};
  settle_axes(figure);
  EXPECT_EQ(figure.panels[0].x.low, 0);
  EXPECT_GT(figure.panels[0].x.high, 2);
  EXPECT_LT(figure.panels[0].y.low, -4);
  EXPECT_GT(figure.panels[0].y.high, 5);
}

TEST(SettleAxes, LogarithmicOnesEndAtWholeDecades) {
  Figure figure{.id = "f", .title = "f", .caption = ""};
  FigurePanel panel{.x = {.scale = AxisScale::logarithmic}, .y = {.scale = AxisScale::logarithmic}};
  panel.series = {{.mark = Mark::points, .x = {0.03, 5, 0, kNone}, .y = {1e-9, 1e-3, 1, 1}}};
  figure.panels = {panel};
  settle_axes(figure);
  EXPECT_NEAR(figure.panels[0].x.low, 0.01, 1e-12);
  EXPECT_NEAR(figure.panels[0].x.high, 10, 1e-9);
  EXPECT_NEAR(figure.panels[0].y.low, 1e-9, 1e-18);
  EXPECT_NEAR(figure.panels[0].y.high, 1, 1e-9);
}

TEST(SettleAxes, PanelsOfAColumnShareTheirX) {
  Figure figure{.id = "f", .title = "f", .caption = "", .shared_x = true};
  FigurePanel a, b;
  a.series = {{.x = {0, 1}, .y = {0, 1}}};
  b.series = {{.x = {5, 9}, .y = {0, 1}}};
  figure.panels = {a, b};
  settle_axes(figure);
  EXPECT_EQ(figure.panels[0].x.high, figure.panels[1].x.high);
  EXPECT_GT(figure.panels[0].x.high, 9);
}

TEST(SettleAxes, NothingToShowStillHasARange) {
  Figure figure{.id = "f", .title = "f", .caption = ""};
  FigurePanel panel;
  panel.series = {{.x = {kNone}, .y = {kNone}}};
  figure.panels = {panel};
  settle_axes(figure);
  EXPECT_LT(figure.panels[0].y.low, figure.panels[0].y.high);
}

}  // namespace

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
