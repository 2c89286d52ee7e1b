#include "apps/text/svg_plot.h"

#include <gtest/gtest.h>

namespace tribotrack::apps {
namespace {

TEST(SvgPlot, PutsDecadesWhereTheyBelong) {
  // x 1e-4 .. 1e-2 over 375 px from 70, y 1e-8 .. 1e-6 over 250 px from 34: the middle decades in the middle.
  const std::string svg =
      svg_of({{{"<t>", {{"a", {{1e-4, 1e-8}, {1e-3, 1e-7}, {1e-2, 1e-6}}, true}}}}, "x", "y"});
  EXPECT_NE(svg.find("cx=\"70.0\" cy=\"284.0\""), std::string::npos);
  EXPECT_NE(svg.find("cx=\"257.5\" cy=\"159.0\""), std::string::npos);
  EXPECT_NE(svg.find("cx=\"445.0\" cy=\"34.0\""), std::string::npos);
  EXPECT_NE(svg.find("&lt;t>"), std::string::npos);
}

TEST(SvgPlot, SurvivesErrorsOfZeroAndNoPointsAtAll) {
  const std::string svg = svg_of({{{"t", {{"a", {{1e-3, 0}, {0, 1}}, false}, {"b", {}, false}}}}, "x", "y"});
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_TRUE(svg_of({{}, "x", "y"}).ends_with("</svg>\n"));
}

}  // namespace
}  // namespace tribotrack::apps
