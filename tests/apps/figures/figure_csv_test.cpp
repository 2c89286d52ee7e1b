#include "apps/figures/figure_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/figures/axes.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

/// Values a millionth apart at 0.1, as parameters are.
Figure narrow() {
  Figure figure{.id = "narrow", .title = "t", .caption = ""};
  FigurePanel panel;
  panel.series = {{.mark = Mark::points,
                   .name = "a, \"b\"",
                   .x = {0.1000001, 0.1000002, 0.10000034567},
                   .y = {1, kNone, 3},
                   .sd = {0.5, kNone, 0.123456},
                   .notes = {"r1", "r2", "r3"}}};
  figure.panels = {panel};
  settle_axes(figure);
  return figure;
}

// No more than a tenth of a pixel is lost, whatever part of the number that is.
TEST(FigureJson, PlacesAreAsFineAsTheAxisShows) {
  const Figure figure = narrow();
  const Json json = json_of(figure);
  const FigureAxis& axis = figure.panels[0].x;
  const Json& x = json["panels"][0]["series"][0]["x"];
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(x[i].get<double>(), figure.panels[0].series[0].x[i], 1e-4 * (axis.high - axis.low));
  EXPECT_TRUE(json["panels"][0]["series"][0]["y"][1].is_null());
}

TEST(FigureCsv, HoldsAllDigitsARowAPoint) {
  const std::string csv = csv_of(narrow());
  EXPECT_THAT(csv, HasSubstr("panel,series,mark,name,x,y,sd,y_high,note\n"));
  EXPECT_THAT(csv, HasSubstr("1,1,points,\"a, \"\"b\"\"\",0.10000034567,3,0.123456,,r3\n"));
  EXPECT_THAT(csv, HasSubstr(",0.1000002,,,,r2\n"));
}

}  // namespace
}  // namespace tribotrack::apps
