#include "apps/report/page/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using nlohmann::json;
using sample::pi;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::Optional;

TEST(BreakAtWraps, ASmoothCurveStaysAsItIs) {
  const BrokenCurve curve = break_at_wraps({0, 1, 2}, {1, 2, 3});
  EXPECT_THAT(curve.x, ElementsAre(Optional(0), Optional(1), Optional(2)));
  EXPECT_THAT(curve.y, ElementsAre(Optional(1), Optional(2), Optional(3)));
}

TEST(BreakAtWraps, ACurveRunningUpThrough2PiIsBrokenThere) {
  // 2 pi - 0.1 to 0.3: crosses 2 pi at a quarter of the step.
  const BrokenCurve curve = break_at_wraps({0, 1}, {2 * pi - 0.1, 0.3});
  ASSERT_EQ(curve.x.size(), 5u);
  EXPECT_NEAR(*curve.x[1], 0.25, 1e-12);
  EXPECT_EQ(*curve.y[1], 2 * pi);
  EXPECT_FALSE(curve.x[2] || curve.y[2]);
  EXPECT_NEAR(*curve.x[3], 0.25, 1e-12);
  EXPECT_EQ(*curve.y[3], 0);
  EXPECT_EQ(*curve.y[4], 0.3);
}

TEST(BreakAtWraps, ACurveRunningDownThrough0IsBrokenThere) {
  const BrokenCurve curve = break_at_wraps({0, 1}, {0.3, 2 * pi - 0.1});
  ASSERT_EQ(curve.x.size(), 5u);
  EXPECT_NEAR(*curve.x[1], 0.75, 1e-12);
  EXPECT_EQ(*curve.y[1], 0);
  EXPECT_FALSE(curve.y[2]);
  EXPECT_EQ(*curve.y[3], 2 * pi);
}

TEST(BreakAtWraps, WhatIsNotFiniteBreaksTheLine) {
  const BrokenCurve curve = break_at_wraps({0, 1, 2}, {0.1, no_value, 6.2});
  EXPECT_THAT(curve.y, ElementsAre(Optional(0.1), std::nullopt, Optional(6.2)));
}

// No two neighbours of the drawn line are ever more than half a turn apart.
TEST(BreakAtWraps, NoVerticalLineIsEverDrawn) {
  std::vector<double> x, y;
  for (int i = 0; i <= 500; ++i) {
    x.push_back(0.05 * i);
    y.push_back(sample::alpha_of(0.05 * i, 1));
  }
  const BrokenCurve curve = break_at_wraps(x, y);
  int breaks = 0;
  for (std::size_t i = 1; i < curve.y.size(); ++i) {
    breaks += !curve.y[i];
    if (curve.y[i] && curve.y[i - 1]) {
      EXPECT_LT(std::abs(*curve.y[i] - *curve.y[i - 1]), pi);
      EXPECT_LE(*curve.x[i - 1], *curve.x[i]);
    }
  }
  EXPECT_EQ(breaks, 4);  // 25 rad from 5.05: at 2, 4, 6 and 8 pi
}

TEST(FiguresJson, HoldsTheMeasuredPointsAndTheModelsCurves) {
  const ReportData data = sample::campaign();
  const json page = json::parse(figures_json(data));
  ASSERT_EQ(page["dependences"].size(), 4u);
  const json& alpha = page["dependences"][0];
  EXPECT_EQ(alpha["id"], "alpha-phi");
  ASSERT_EQ(alpha["groups"].size(), 1u);
  EXPECT_EQ(alpha["groups"][0]["label"], "Δτ = π/3");
  const json& points = alpha["groups"][0]["points"];
  ASSERT_EQ(points["x"].size(), 8u);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_NEAR(points["x"][k].get<double>(), static_cast<double>(k) * pi / 4, 1e-6);
    EXPECT_NEAR(points["y"][k].get<double>(), data.runs[k].alpha_rad, 1e-6);
    EXPECT_NEAR(points["sd"][k].get<double>(), data.runs[k].alpha_sd_rad, 1e-6);
  }
  EXPECT_EQ(alpha["groups"][0]["curve"]["x"].size(), 121u + 3u);  // broken once
  EXPECT_EQ(page["dependences"][3]["id"], "v-dtau");
  EXPECT_EQ(page["dependences"][3]["groups"][0]["points"]["y"].size(), 7u);
  EXPECT_EQ(page["trajectories"].size(), 13u);
  EXPECT_EQ(page["residuals"].size(), 28u);
  EXPECT_EQ(page["slides"][0]["residual_um"].size(), 100u);
}

TEST(FiguresJson, WhatIsNotANumberIsNull) {
  const json page = json::parse(figures_json(sample::campaign()));
  const json& x = page["trajectories"][7]["x"];  // frames 200 to 202 were lost
  EXPECT_TRUE(x[199].is_number());
  EXPECT_TRUE(x[200].is_null());
  EXPECT_TRUE(x[202].is_null());
  EXPECT_TRUE(x[203].is_number());
}

TEST(FiguresJson, NothingInItCanCloseTheScript) {
  ReportData data = sample::campaign();
  data.runs[0].name = "</script><!-- \xff";  // also not UTF-8
  const std::string text = figures_json(data);
  EXPECT_EQ(text.find('<'), std::string::npos);
  EXPECT_THAT(json::parse(text)["trajectories"][0]["label"].get<std::string>(), HasSubstr("</script><!--"));
}

TEST(FiguresJson, LongPathsAreThinnedForDrawing) {
  ReportData data = sample::campaign();
  data.runs[0].x_mm.assign(100000, 1.5);
  data.runs[0].y_mm.assign(100000, 2.5);
  const json page = json::parse(figures_json(data));
  EXPECT_LE(page["trajectories"][0]["x"].size(), 3000u);
  EXPECT_GE(page["trajectories"][0]["x"].size(), 2900u);
}

TEST(FigureSections, AFigureWithoutDataIsLeftOutAndSaid) {
  ReportData data = sample::campaign();
  data.over_dtau.clear();
  EXPECT_THAT(dependence_section(data), HasSubstr("No two runs differ in Δτ"));
  EXPECT_THAT(dependence_section(data), Not(HasSubstr("plot-v-dtau")));
  EXPECT_THAT(dependence_section(data), HasSubstr("plot-alpha-phi"));
  EXPECT_EQ(json::parse(figures_json(data))["dependences"].size(), 2u);
  EXPECT_THAT(trajectory_plot(ReportData{}), HasSubstr("left out"));
  EXPECT_EQ(slide_section(ReportData{}), "");
}

TEST(ReportFigures, SlidesStandOneByOneInATable) {
  ReportData data = sample::campaign();
  data.slide_results.push_back({.name = "man <1>",
                                .mu1 = 0.1482,
                                .mu1_sd = 0.0021,
                                .ci95 = {0.144, 0.1524},
                                .chi2 = 131,
                                .dof = 152,
                                .first_frame = 194,
                                .last_frame = 272,
                                .spin_seen = true,
                                .spin_ratio = 0.731,
                                .spin_ratio_sd = 0.012});
  data.slide_results.push_back(
      {.name = "man 2", .mu1 = 0.204, .mu1_sd = 0.003, .change_by_half_spin = 0.091, .blow_frames = {301}});
  data.between_slides = 0.018;
  data.between_slides_p_value = 1e-8;
  const std::string html = slide_section(data);
  for (const char* part : {"man &lt;1&gt;", "0.1482 ± 0.0021", "0.731 ± 0.012", "131 / 152", "194–272",
                           "not seen (half: +9.1 %)", "frame 301", "standard deviation of 0.018",
                           "more than chance explains, p = 1e-08"})
    EXPECT_THAT(html, testing::HasSubstr(part));
}

}  // namespace
}  // namespace tribotrack::apps
