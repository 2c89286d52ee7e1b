#include "apps/bench/figures/figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "apps/bench/figures/log_log.h"

namespace tribotrack::bench {
namespace {

using namespace apps;

/// The series of that mark and name in a panel; one without points where there is none.
Series series_in(const FigurePanel& panel, Mark mark, const std::string& name) {
  for (const Series& series : panel.series)
    if (series.mark == mark && series.name == name) return series;
  return {};
}

std::vector<ModelBenchRow> model_rows() {
  std::vector<ModelBenchRow> rows;
  for (const char* scene : {"s1", "s2"})
    for (const auto& [method, time, error, over_ours] : {std::tuple("tribotrack", 1e-5, 1e-9, NAN),
                                                         {"tribotrack", 2e-5, 1e-12, NAN},
                                                         {"odeint Fehlberg 7(8), segmented", 3e-5, 1e-8, 0.5},
                                                         {"odeint Fehlberg 7(8), by clock", 3e-4, 1e-7, 30.0},
                                                         {"CVODE BDF, by clock", 3e-3, 0.0, 300.0}}) {
      ModelBenchRow row;
      row.scene = scene;
      row.method = method;
      row.ours = row.method == "tribotrack";
      row.time = time;
      row.error = error;
      row.time_over_ours = over_ours;
      rows.push_back(row);
    }
  return rows;
}

TEST(BenchFigures, HoldTheRowsNumbersInOneSeriesForEachMethod) {
  const Figure figure = model_figure(model_rows());
  ASSERT_EQ(figure.panels.size(), 2U);
  for (const FigurePanel& panel : figure.panels) {
    EXPECT_EQ(series_in(panel, Mark::points, "tribotrack").x, (std::vector<double>{1e-5, 2e-5}));
    EXPECT_EQ(series_in(panel, Mark::points, "tribotrack").y, (std::vector<double>{1e-9, 1e-12}));
    EXPECT_EQ(series_in(panel, Mark::line, "tribotrack").y, (std::vector<double>{1e-9, 1e-12}));
    std::vector<double> of_odeint;  // two methods, one entry
    for (const Series& series : panel.series)
      if (series.name == "Boost.odeint" && series.mark == Mark::points)
        of_odeint.insert(of_odeint.end(), series.y.begin(), series.y.end());
    EXPECT_EQ(of_odeint, (std::vector<double>{1e-8, 1e-7}));
    const Series rings = series_in(panel, Mark::text, "a peer wins");
    EXPECT_EQ(rings.x, std::vector<double>{3e-5}) << "where a peer is faster";
    EXPECT_EQ(rings.y, std::vector<double>{1e-8});
  }
  EXPECT_NE(figure.caption.find("2 points where a peer wins"), std::string::npos) << figure.caption;
}

TEST(BenchFigures, HaveTheSameWholeDecadesInAllPanels) {
  auto rows = model_rows();
  rows.back().time = 0.2;
  const Figure figure = model_figure(rows);
  for (const FigurePanel& panel : figure.panels) {
    EXPECT_EQ(panel.x.scale, AxisScale::logarithmic);
    EXPECT_DOUBLE_EQ(panel.x.low, 1e-5);
    EXPECT_DOUBLE_EQ(panel.x.high, 1);
    EXPECT_DOUBLE_EQ(panel.y.low, 1e-12);
    EXPECT_DOUBLE_EQ(panel.y.high, 1e-7);
    EXPECT_EQ(panel.y.labels.front(), "10⁻¹²");
  }
}

TEST(BenchFigures, DrawWhatHasNoLogarithmAtTheEdgeAndSaySo) {
  const Figure figure = model_figure(model_rows());
  const Series zero = series_in(figure.panels[0], Mark::points, "SUNDIALS CVODE");
  ASSERT_EQ(zero.y.size(), 1U);
  EXPECT_DOUBLE_EQ(zero.y[0], 1e-12);
  EXPECT_NE(zero.notes[0].find("0, at the lower edge"), std::string::npos) << zero.notes[0];
  EXPECT_NE(figure.caption.find("At the lower edge: 2 points"), std::string::npos) << figure.caption;

  const std::vector<LogLogPoint> points{{"p", "m", "m", "m", 0, 1}, {"p", "m", "m", "m", 1, INFINITY}};
  const LogLogText text{"id", "title", "", "x", "y"};
  const Figure edges = log_log_figure(text, points);
  EXPECT_NE(edges.caption.find("At the lower edge: one point"), std::string::npos) << edges.caption;
  EXPECT_NE(edges.caption.find("Not drawn: one point"), std::string::npos) << edges.caption;
  EXPECT_TRUE(log_log_figure(text, {}).panels.empty());
}

TEST(BenchFigures, GiveOneColourToOneNameAndGroupWhatALegendCannotHold) {
  std::vector<LogLogPoint> points;
  for (int k = 0; k < 12; ++k) {
    const std::string name = "m" + std::to_string(k);
    for (const char* panel : {"a", "b"})
      points.push_back({panel, name, name, name, 1.0 + k, 1.0 + k, k == 5, false, false});
  }
  const Figure figure = log_log_figure({"id", "title", "", "x", "y"}, points);
  std::vector<std::string> legend;
  for (const FigurePanel& panel : figure.panels) {
    for (const Series& series : panel.series) {
      if (series.in_legend) legend.push_back(series.name);
      EXPECT_EQ(series.large, series.name == "m5") << series.name;
      const Series twin = series_in(figure.panels[0], series.mark, series.name);
      EXPECT_EQ(series.colour, twin.colour);
    }
    EXPECT_EQ(series_in(panel, Mark::points, "m5").colour, 0) << "ours first";
  }
  EXPECT_EQ(legend.size(), kMostInLegend) << "each name once in the figure";
  EXPECT_NE(std::ranges::find(legend, "others"), legend.end());
}

TEST(BenchFigures, TrackingShowsTheNoiseItNames) {
  std::vector<VisionBenchRow> rows(3);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].scene = "plain";
    rows[k].radius = 12;
    rows[k].noise = k == 2 ? 4 : kDrawnNoise;
    rows[k].method = k == 1 ? "grey centroid" : "tribotrack track";
    rows[k].ours = k != 1;
    rows[k].bound = 0.01;
    rows[k].rms = 0.02;
    rows[k].time = 1e-3;
    rows[k].rms_over_ours = k == 1 ? 0.9 : 1;
  }
  const Figure figure = tracking_figure(rows);
  ASSERT_EQ(figure.panels.size(), 1U);
  EXPECT_EQ(figure.panels[0].title, "plain, R = 12 px");
  EXPECT_EQ(series_in(figure.panels[0], Mark::points, "tribotrack track").y, std::vector<double>{2});
  EXPECT_EQ(series_in(figure.panels[0], Mark::text, "a peer wins").y, std::vector<double>{2});
}

TEST(BenchFigures, CoverageHasItsBinomialRanges) {
  CoverageRow row;
  row.parameter = "mu1";
  row.campaigns = row.usable = 200;
  row.covered = 190;
  CoverageRow none = row;
  none.parameter = "mu2";
  none.usable = none.covered = 0;
  const Figure figure = coverage_figure({row, none});
  ASSERT_EQ(figure.panels.size(), 1U);
  const Series share = series_in(figure.panels[0], Mark::points, "μ₁");
  EXPECT_EQ(share.x, std::vector<double>{95});
  const Series range = series_in(figure.panels[0], Mark::line, "μ₁");
  ASSERT_EQ(range.x.size(), 3U);
  EXPECT_DOUBLE_EQ(range.x[0], 100 * row.share_ci95().low);
  EXPECT_DOUBLE_EQ(range.x[1], 100 * row.share_ci95().high);
  EXPECT_TRUE(series_in(figure.panels[0], Mark::points, "μ₂").x.empty()) << "nothing usable, nothing to draw";
  EXPECT_EQ(series_in(figure.panels[0], Mark::line, "nominal 95 %").x, (std::vector<double>{95, 95}));
}

TEST(BenchFigures, CostsAreDrawnBesideThoseOfTheSmallest) {
  const std::vector<ScaleRow> rows = {{"runs", 10, 2, 2, 1e8, {}},
                                      {"runs", 1000, 50, 50, 3e8, {}},
                                      {"frames", 5, 4, 4, 1e8, 30.0},
                                      {"frames", 500, 400, 400, 1e8, 30.0}};
  const Figure figure = scale_figure(rows);
  ASSERT_EQ(figure.panels.size(), 3U);
  EXPECT_EQ(series_in(figure.panels[0], Mark::points, "runs").x, (std::vector<double>{1, 100}));
  EXPECT_EQ(series_in(figure.panels[0], Mark::points, "runs").y, (std::vector<double>{1, 25}));
  EXPECT_EQ(series_in(figure.panels[1], Mark::points, "runs").y, (std::vector<double>{1, 3}));
  EXPECT_EQ(series_in(figure.panels[2], Mark::points, "frames").y, (std::vector<double>{1, 1}));
  EXPECT_TRUE(series_in(figure.panels[2], Mark::points, "runs").x.empty()) << "nobody counted";
}

}  // namespace
}  // namespace tribotrack::bench
