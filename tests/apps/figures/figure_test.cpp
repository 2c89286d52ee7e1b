#include "apps/figures/figure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace tribotrack::apps {
namespace {

using testing::ElementsAre;
using testing::IsNan;

constexpr double kPi = std::numbers::pi;

Notes texts(const Json& axis) {
  return axis.at("ticktext").get<Notes>();
}

Values ends(const Json& axis) {
  return plot::values_of(axis, "range");
}

Figure settled(std::vector<Panel> panels, bool shared_x = false) {
  Figure figure{.id = "f", .title = "f", .caption = "", .panels = std::move(panels), .shared_x = shared_x};
  settle_axes(figure);
  return figure;
}

TEST(AngleAxis, AWholeTurnHasQuarters) {
  EXPECT_THAT(texts(plot::angle_axis("", 0, 2 * kPi)),
              ElementsAre("0", "π/4", "π/2", "3π/4", "π", "5π/4", "3π/2", "7π/4", "2π"));
}

TEST(AngleAxis, ValuesOnSixthsHaveThirds) {
  EXPECT_THAT(texts(plot::angle_axis("", 0.4, 3.2, {kPi / 6, kPi / 3, kPi})),
              ElementsAre("π/6", "π/3", "π/2", "2π/3", "5π/6", "π"));
}

// 43 pi / 24 is no sensible tick.
TEST(AngleAxis, ARangeTooShortForTwelfthsHasDecimals) {
  EXPECT_FALSE(plot::angle_axis("", 5.6, 5.7).contains("tickvals"));
}

TEST(SettleAxes, EndsThatAreGivenStayAndTheOthersHoldTheData) {
  const Panel panel = settled({{.x = plot::axis("", 0),
                                .y = plot::axis(""),
                                .traces = {plot::points("", {1, 2}, {-3, 4}, {}, {}, {1, 1})}}})
                          .panels[0];
  EXPECT_EQ(ends(panel.x)[0], 0);
  EXPECT_GT(ends(panel.x)[1], 2);
  EXPECT_LT(ends(panel.y)[0], -4);
  EXPECT_GT(ends(panel.y)[1], 5);
}

TEST(SettleAxes, LogarithmicOnesEndAtWholeDecades) {
  const Panel panel = settled({{.x = plot::log_axis(""),
                                .y = plot::log_axis(""),
                                .traces = {plot::points("", {0.03, 5, 0, kNone}, {1e-9, 1e-3, 1, 1})}}})
                          .panels[0];
  EXPECT_THAT(ends(panel.x), ElementsAre(-2, 1));
  EXPECT_THAT(ends(panel.y), ElementsAre(-9, 0));
}

TEST(Thinned, EveryGapStaysAGap) {
  EXPECT_THAT(thinned({0, kNone, 2, 3}, {0, 1, 2, 3}, 4).x, ElementsAre(0, IsNan(), 2, 3));
  EXPECT_THAT(thinned({0, 1, 2, 3}, {0, 1, kNone, 3}, 4).y, ElementsAre(0, 1, IsNan(), 3));
  EXPECT_THAT(thinned({0, kNone, 2, 3}, {0, 1, 2, 3}, 2).x, ElementsAre(0, IsNan(), 2))
      << "between drawn points";
  EXPECT_THAT(thinned({0, 1, kNone, 3, 4, 5}, {0, 1, 2, 3, 4, 5}, 3).x, ElementsAre(0, IsNan(), 4))
      << "on a drawn point";
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

/// Values a millionth apart at 0.1, as parameters are.
Figure narrow() {
  return settled({{.x = plot::axis(""), .y = plot::axis(""), .traces = {}},
                  {.x = plot::axis(""),
                   .y = plot::axis(""),
                   .traces = {plot::points("a, \"b\"", {0.1000001, 0.1000002, 0.10000034567}, {1, kNone, 3},
                                           {}, {"r1", "r2", "r3"}, {0.5, kNone, 0.123456})},
                   .shapes = {plot::stripe(-2, 2)}}});
}

// No more than a tenth of a pixel is lost, whatever part of the number that is.
TEST(PlotlyJson, PlacesAreAsFineAsTheAxisShows) {
  const Figure figure = narrow();
  const Json trace = plotly_json(figure)["data"][0];
  const Values wanted = plot::values_of(figure.panels[1].traces[0], "x"), axis = ends(figure.panels[1].x);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(trace["x"][i].get<double>(), wanted[i], 1e-4 * (axis[1] - axis[0]));
  EXPECT_TRUE(trace["y"][1].is_null());
  EXPECT_EQ(trace["error_y"]["array"][2], 0.123);
}

}  // namespace
}  // namespace tribotrack::apps
