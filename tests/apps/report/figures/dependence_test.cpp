#include "apps/report/figures/dependence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using sample::pi;
using testing::HasSubstr;
using testing::Not;

const Series& first(const FigurePanel& panel, Mark mark) {
  const auto found = std::ranges::find(panel.series, mark, &Series::mark);
  EXPECT_NE(found, panel.series.end());
  return *found;
}

ReportData with_curve(std::vector<double> x, std::vector<double> alpha) {
  ReportData data = sample::campaign();
  data.over_phi[0].curve_x_rad = std::move(x);
  data.over_phi[0].curve_alpha_rad = std::move(alpha);
  data.over_phi[0].curve_alpha_sd_rad.clear();
  data.over_phi[0].curve_v_mm_s.assign(data.over_phi[0].curve_x_rad.size(), 1);
  data.over_phi[0].curve_v_sd_mm_s.clear();
  return data;
}

Series line_of(std::vector<double> x, std::vector<double> alpha) {
  return first(dependence_figures(with_curve(std::move(x), std::move(alpha)))[0].panels[0], Mark::line);
}

TEST(Dependence, ACurveRunningUpThrough2PiIsBrokenThere) {
  // 2 pi - 0.1 to 0.3: crosses 2 pi at a quarter of the step.
  const Series line = line_of({0, 1}, {2 * pi - 0.1, 0.3});
  ASSERT_EQ(line.x.size(), 5u);
  EXPECT_NEAR(line.x[1], 0.25, 1e-12);
  EXPECT_EQ(line.y[1], 2 * pi);
  EXPECT_TRUE(std::isnan(line.y[2]));
  EXPECT_NEAR(line.x[3], 0.25, 1e-12);
  EXPECT_EQ(line.y[3], 0);
  EXPECT_EQ(line.y[4], 0.3);
}

TEST(Dependence, ACurveRunningDownThrough0IsBrokenThere) {
  const Series line = line_of({0, 1}, {0.3, 2 * pi - 0.1});
  ASSERT_EQ(line.x.size(), 5u);
  EXPECT_NEAR(line.x[1], 0.75, 1e-12);
  EXPECT_EQ(line.y[1], 0);
  EXPECT_TRUE(std::isnan(line.y[2]));
  EXPECT_EQ(line.y[3], 2 * pi);
}

// No two neighbours of the drawn line are ever more than half a turn apart.
TEST(Dependence, NoVerticalLineIsEverDrawn) {
  std::vector<double> x, y;
  for (int i = 0; i <= 500; ++i) {
    x.push_back(0.05 * i);
    y.push_back(sample::alpha_of(0.05 * i, 1));
  }
  const Series line = line_of(x, y);
  int breaks = 0;
  for (std::size_t i = 1; i < line.y.size(); ++i) {
    breaks += std::isnan(line.y[i]);
    if (!std::isnan(line.y[i]) && !std::isnan(line.y[i - 1])) {
      EXPECT_LT(std::abs(line.y[i] - line.y[i - 1]), pi);
      EXPECT_LE(line.x[i - 1], line.x[i]);
    }
  }
  EXPECT_EQ(breaks, 4);  // 25 rad from 5.05: at 2, 4, 6 and 8 pi
}

TEST(Dependence, HoldsTheMeasuredPointsTheModelAndItsBand) {
  const ReportData data = sample::campaign();
  const std::vector<Figure> figures = dependence_figures(data);
  ASSERT_EQ(figures.size(), 4u);
  EXPECT_EQ(figures[0].id, "alpha-phi");
  EXPECT_EQ(figures[3].id, "v-dtau");
  const FigurePanel& main = figures[0].panels[0];
  const Series& points = first(main, Mark::points);
  EXPECT_EQ(points.name, "Δτ = π/3");
  EXPECT_TRUE(points.in_legend);
  ASSERT_EQ(points.x.size(), 8u);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_NEAR(points.x[k], static_cast<double>(k) * pi / 4, 1e-12);
    EXPECT_EQ(points.y[k], data.runs[k].alpha_rad);
    EXPECT_EQ(points.sd[k], data.runs[k].alpha_sd_rad);
  }
  const Series &line = first(main, Mark::line), &band = first(main, Mark::band);
  ASSERT_EQ(band.x.size(), line.x.size());
  for (std::size_t i = 0; i < line.x.size(); ++i) {
    if (std::isnan(line.y[i])) continue;
    EXPECT_NEAR(band.y[i], line.y[i] - 0.0196, 1e-9);
    EXPECT_NEAR(band.y_high[i], line.y[i] + 0.0196, 1e-9);
  }
}

TEST(Dependence, BelowStandTheResidualsInStandardDeviations) {
  ReportData data = sample::campaign();
  data.runs[0].alpha_rad = 0.05;  // across the seam at 2 pi
  data.runs[0].modelled_alpha_rad = 2 * pi - 0.05;
  data.runs[0].alpha_sd_rad = 0.05;
  const FigurePanel below = dependence_figures(data)[0].panels[1];
  EXPECT_NEAR(first(below, Mark::points).y[0], 2, 1e-9);
  ASSERT_EQ(below.stripes.size(), 1u);
  EXPECT_EQ(below.stripes[0].high, 2);
}

TEST(Dependence, MoreGroupsThanALegendHoldsAreToldApartByColour) {
  ReportData data = sample::campaign();
  const ReportGroup group = data.over_phi[0];
  for (int k = 1; k < 12; ++k) {
    data.over_phi.push_back(group);
    data.over_phi.back().shared_rad += 0.1 * k;
  }
  const Figure figure = dependence_figures(data)[0];
  ASSERT_TRUE(figure.colours);
  EXPECT_NEAR(figure.colours->high - figure.colours->low, 1.1, 1e-12);
  for (const FigurePanel& panel : figure.panels)
    for (const Series& series : panel.series) {
      EXPECT_FALSE(series.in_legend);
      EXPECT_FALSE(std::isnan(series.value));
      EXPECT_NE(series.mark, Mark::band);
    }
  EXPECT_THAT(figure.caption, HasSubstr("With 12 groups colour tells the value they share"));
}

TEST(Dependence, WithoutRunsToCompareThereIsNoFigure) {
  ReportData data = sample::campaign();
  data.over_dtau.clear();
  EXPECT_EQ(dependence_figures(data).size(), 2u);
  EXPECT_TRUE(dependence_figures(ReportData{}).empty());
}

}  // namespace
}  // namespace tribotrack::apps
