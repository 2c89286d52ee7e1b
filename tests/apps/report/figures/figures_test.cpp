// The figures besides those of alpha and v: trajectories, residuals, parameters, single runs.
#include "apps/report/figures/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

Figure figure(const std::vector<Figure>& figures, const std::string& id) {
  const auto found = std::ranges::find(figures, id, &Figure::id);
  if (found == figures.end()) throw std::runtime_error("no figure " + id);
  return *found;
}

std::size_t legend_entries(const Figure& figure) {
  std::set<std::string> names;
  for (const FigurePanel& panel : figure.panels)
    for (const Series& series : panel.series)
      if (series.in_legend) names.insert(series.name);
  return names.size();
}

TEST(ReportFigures, EachHasItsAxesSettledALegendThatCanBeReadAndAnAlternative) {
  for (const Figure& f : campaign_figures(sample::campaign())) {
    EXPECT_LE(legend_entries(f), kMostInLegend) << f.id;
    EXPECT_NE(f.alternative, "") << f.id;
    EXPECT_NE(f.caption, "") << f.id;
    for (const FigurePanel& panel : f.panels) {
      if (panel.series.empty()) continue;
      EXPECT_LT(panel.x.low, panel.x.high) << f.id;
      EXPECT_LT(panel.y.low, panel.y.high) << f.id;
    }
  }
}

TEST(ReportFigures, TrajectoriesHoldPathModelAndCycleMarksWithTheGapsOfTheTrack) {
  const ReportData data = sample::campaign();
  const Figure f = figure(campaign_figures(data), "trajectories");
  EXPECT_TRUE(f.panels[0].equal_scale);
  long lines = 0, dashed = 0, marks = 0;
  for (const Series& series : f.panels[0].series) {
    lines += series.mark == Mark::line && !series.dashed;
    dashed += series.mark == Mark::line && series.dashed;
    marks += series.mark == Mark::points;
  }
  EXPECT_EQ(lines, 13);
  EXPECT_EQ(dashed, 13);
  EXPECT_EQ(marks, 13);
  // Frames 200 to 202 of run 8 were lost: a gap, which no line crosses.
  const Series& path = f.panels[0].series[3 * 7];
  EXPECT_TRUE(std::isfinite(path.y[199]));
  EXPECT_TRUE(std::isnan(path.y[200]));
}

TEST(ReportFigures, ResidualsAreAsManyAsDegreesOfFreedom) {
  ReportData data = sample::campaign();
  for (ReportRun& run : data.runs)
    if (!run.residuals.empty()) {
      run.residuals.push_back({"alpha_rad", 1, 1, 0.1, 0.3});  // the same two numbers, seen otherwise
      run.residuals.push_back({"v_mm_s", 1, 1, 0.1, 0.3});
    }
  const Figure f = figure(campaign_figures(data), "residuals");
  std::size_t shown = 0;
  for (const Series& series : f.panels[0].series) {
    EXPECT_TRUE(series.name == "dx" || series.name == "dy") << series.name;
    shown += series.y.size();
  }
  EXPECT_EQ(shown, 2u * 14);
}

TEST(ReportFigures, TheProfileOfAParabolaIsTheParabola) {
  const ReportData data = sample::campaign();
  const Figure f = figure(campaign_figures(data), "corner");
  EXPECT_EQ(f.panels.size(), 9u);
  EXPECT_TRUE(f.panels[1].series.empty()) << "above the diagonal";
  const ReportParameter& mu1 = data.parameters[0];
  const auto& series = f.panels[0].series;
  const auto profile = std::ranges::find(series, std::string("profile likelihood"), &Series::name);
  ASSERT_NE(profile, series.end());
  for (std::size_t i = 0; i < profile->x.size(); ++i)
    EXPECT_NEAR(profile->y[i], std::pow((profile->x[i] - mu1.estimate) / mu1.sd, 2), 1e-6);
}

// Every point of the 95 % ellipse lies where the quadratic form of the covariance is -2 ln 0.05.
TEST(ReportFigures, PairsLieInTheirRegions) {
  const ReportData data = sample::campaign();
  const Figure f = figure(campaign_figures(data), "corner");
  const ReportParameter &a = data.parameters[0], &b = data.parameters[1];
  const double r = data.correlation[1][0];
  const Series& outer = f.panels[3].series[1];
  ASSERT_EQ(outer.name, "95 % region");
  for (std::size_t i = 0; i < outer.x.size(); ++i) {
    const double x = (outer.x[i] - a.estimate) / a.sd, y = (outer.y[i] - b.estimate) / b.sd;
    EXPECT_NEAR((x * x - 2 * r * x * y + y * y) / (1 - r * r), -2 * std::log(0.05), 1e-9);
  }
}

TEST(ReportFigures, SharesOfTheBudgetAreThoseOfTheVariance) {
  const Figure f = figure(campaign_figures(sample::campaign()), "budget-shares");
  ASSERT_EQ(f.panels.size(), 3u);
  const Series& bars = f.panels[0].series[0];
  EXPECT_THAT(bars.notes, testing::ElementsAre("tracking noise", "scale"));
  EXPECT_NEAR(bars.x[0], 100 * std::pow(0.00029 / 0.00031, 2), 1e-9);
}

TEST(ReportFigures, ARunOverTimeShowsWhereThePartWasLost) {
  const ReportData data = sample::campaign();
  const Figure f = run_figures(data, 7).front();
  EXPECT_EQ(f.id, "run-8");
  ASSERT_EQ(f.panels.size(), 4u);  // position, residual, sigma, score; the part does not turn
  ASSERT_EQ(f.panels[0].spans.size(), 1u);
  EXPECT_NEAR(f.panels[0].spans[0].low, 200 / 250.0, 1e-12);
  EXPECT_NEAR(f.panels[0].spans[0].high, 203 / 250.0, 1e-12);
  EXPECT_THAT(f.caption, HasSubstr("Shaded: the part was not found"));
  EXPECT_THAT(f.caption, HasSubstr("Of 501 frames at most 180 points"));
  const Series& left = f.panels[1].series[0];
  double largest = 0, wanted = 0;
  for (const double y : left.y)
    if (std::isfinite(y)) largest = std::max(largest, y);
  double mean = 0;
  std::size_t count = 0;
  const ReportRun& run = data.runs[7];
  for (std::size_t i = 0; i < run.x_mm.size(); ++i)
    if (std::isfinite(run.x_mm[i])) {
      mean += 1000 * (run.x_mm[i] - run.model_x_mm[i]);
      ++count;
    }
  mean /= static_cast<double>(count);
  for (std::size_t i = 0; i < run.x_mm.size(); ++i)
    if (std::isfinite(run.x_mm[i]))
      wanted = std::max(wanted, 1000 * (run.x_mm[i] - run.model_x_mm[i]) - mean);
  EXPECT_NEAR(largest, wanted, 1e-9) << "the envelope lost the largest residual";
}

TEST(ReportFigures, ARunMeasuredElsewhereHasNone) {
  EXPECT_TRUE(run_figures(sample::campaign(), 13).empty());
}

}  // namespace
}  // namespace tribotrack::apps
