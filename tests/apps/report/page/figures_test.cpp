#include "apps/report/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using sample::pi;

const Json& first(const Panel& panel, const std::string& mode, bool filled = false) {
  const auto found = std::ranges::find_if(panel.traces, [&](const Json& trace) {
    return trace.value("mode", "") == mode && trace.contains("fill") == filled;
  });
  if (found == panel.traces.end()) throw std::runtime_error("no trace of " + mode);
  return *found;
}

/// A trace's places, by the names of a drawn path.
DrawnPath path_of(const Json& trace) {
  return {plot::values_of(trace, "x"), plot::values_of(trace, "y")};
}

bool dashed(const Json& trace) {
  return trace.contains("line") && trace["line"].value("dash", "") == "dash";
}

TEST(Dependence, ACurveRunningUpThrough2PiIsBrokenThere) {
  // 2 pi - 0.1 to 0.3: crosses 2 pi at a quarter of the step.
  ReportData data = sample::campaign();
  ReportGroup& group = data.over_phi[0];
  group.curve_x_rad = {0, 1};
  group.curve_alpha_rad = {2 * pi - 0.1, 0.3};
  group.curve_v_mm_s = {1, 1};
  group.curve_alpha_sd_rad = group.curve_v_sd_mm_s = {};
  const DrawnPath line = path_of(first(dependence_figures(data)[0].panels[0], "lines"));
  ASSERT_EQ(line.x.size(), 5u);
  EXPECT_NEAR(line.x[1], 0.25, 1e-12);
  EXPECT_EQ(line.y[1], 2 * pi);
  EXPECT_TRUE(std::isnan(line.y[2]));
  EXPECT_NEAR(line.x[3], 0.25, 1e-12);
  EXPECT_EQ(line.y[3], 0);
  EXPECT_EQ(line.y[4], 0.3);
}

TEST(Dependence, HoldsTheMeasuredPointsTheModelAndItsBand) {
  const ReportData data = sample::campaign();
  const std::vector<Figure> figures = dependence_figures(data);
  ASSERT_EQ(figures.size(), 4u);
  EXPECT_EQ(figures[0].id, "alpha-phi");
  EXPECT_EQ(figures[3].id, "v-dtau");
  const Panel& main = figures[0].panels[0];
  const Json& trace = first(main, "markers");
  EXPECT_EQ(trace["name"], "Δτ = π/3");
  EXPECT_TRUE(trace["showlegend"]);
  const DrawnPath points = path_of(trace);
  const Values sd = plot::values_of(trace["error_y"], "array");
  ASSERT_EQ(points.x.size(), 8u);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_NEAR(points.x[k], static_cast<double>(k) * pi / 4, 1e-12);
    EXPECT_EQ(points.y[k], data.runs[k].value("alpha_rad").value);
    EXPECT_EQ(sd[k], data.runs[k].value("alpha_rad").sd);
  }
  const DrawnPath line = path_of(first(main, "lines")), band = path_of(first(main, "lines", true));
  const Values high = plot::values_of(first(main, "lines", true), "customdata");
  ASSERT_EQ(band.x.size(), line.x.size());
  for (std::size_t i = 0; i < line.x.size(); ++i) {
    if (std::isnan(line.y[i])) continue;
    EXPECT_NEAR(band.y[i], line.y[i] - 0.0196, 1e-9);
    EXPECT_NEAR(high[i], line.y[i] + 0.0196, 1e-9);
  }
}

TEST(Dependence, BelowStandTheResidualsInStandardDeviations) {
  ReportData data = sample::campaign();
  data.runs[0].measured["alpha_rad"] = {0.05, 0.05};  // across the seam at 2 pi
  data.runs[0].fitted.residuals = {{"alpha_rad", 0.05, 2 * pi - 0.05, 0.05, 2}};
  const Panel below = dependence_figures(data)[0].panels[1];
  EXPECT_NEAR(path_of(first(below, "markers")).y[0], 2, 1e-9);
  ASSERT_EQ(below.shapes.size(), 1u);
  EXPECT_EQ(below.shapes[0]["y1"], 2);
  data.runs[0].fitted.residuals[0].sd = 0.1;  // chi^2 divides by the run's scatter, too
  EXPECT_NEAR(path_of(first(dependence_figures(data)[0].panels[1], "markers")).y[0], 1, 1e-9);
}

}  // namespace

// The figures besides those of alpha and v: trajectories, residuals, parameters, single runs.

namespace {

Figure figure(const std::vector<Figure>& figures, const std::string& id) {
  const auto found = std::ranges::find(figures, id, &Figure::id);
  if (found == figures.end()) throw std::runtime_error("no figure " + id);
  return *found;
}

TEST(ReportFigures, TrajectoriesHoldPathModelAndCycleMarksWithTheGapsOfTheTrack) {
  const ReportData data = sample::campaign();
  const Figure f = figure(campaign_figures(data), "trajectories");
  EXPECT_TRUE(f.panels[0].equal_scale);
  long lines = 0, models = 0, marks = 0;
  for (const Json& trace : f.panels[0].traces) {
    lines += trace["mode"] == "lines" && !dashed(trace);
    models += dashed(trace);
    marks += trace["mode"] == "markers";
  }
  EXPECT_EQ(lines, 13);
  EXPECT_EQ(models, 13);
  EXPECT_EQ(marks, 13);
  // Frames 200 to 202 of run 8 were lost: a gap, which no line crosses.
  const DrawnPath path = path_of(f.panels[0].traces[3 * 7]);
  EXPECT_TRUE(std::isfinite(path.y[199]));
  EXPECT_TRUE(std::isnan(path.y[200]));
}

TEST(ReportFigures, ResidualsAreAsManyAsDegreesOfFreedom) {
  // alpha and v are the same two numbers as dx and dy, seen otherwise.
  const Figure f = figure(campaign_figures(sample::campaign()), "residuals");
  std::size_t shown = 0;
  for (const Json& trace : f.panels[0].traces) {
    EXPECT_TRUE(trace["name"] == "dx" || trace["name"] == "dy") << trace["name"];
    shown += trace["y"].size();
  }
  EXPECT_EQ(shown, 2u * 14);
}

TEST(ReportFigures, TheProfileOfAParabolaIsTheParabola) {
  const ReportData data = sample::campaign();
  const Figure f = figure(campaign_figures(data), "corner");
  EXPECT_EQ(f.panels.size(), 9u);
  EXPECT_TRUE(f.panels[1].traces.empty()) << "above the diagonal";
  const fit::ParameterEstimate& mu1 = data.fit.parameters[0];
  ASSERT_EQ(f.panels[0].traces[1]["name"], "profile likelihood");
  const DrawnPath profile = path_of(f.panels[0].traces[1]);
  for (std::size_t i = 0; i < profile.x.size(); ++i)
    EXPECT_NEAR(profile.y[i], std::pow((profile.x[i] - mu1.estimate) / mu1.sd, 2), 1e-6);
}

TEST(ReportFigures, FrictionIsDrawnOverTheSpeedsSeenWhereItDependsOnSpeed) {
  ReportData data = sample::campaign();
  const auto is_drawn = [&] {
    return std::ranges::count(campaign_figures(data), "friction", &Figure::id) > 0;
  };
  EXPECT_FALSE(is_drawn());
  data.fit.mu_of_speed = {{0, 0.2, 0.01}, {0.1, 0.15, 0.002}};
  ASSERT_TRUE(is_drawn());
  const Panel panel = figure(campaign_figures(data), "friction").panels.front();
  EXPECT_EQ(plot::values_of(panel.traces.back(), "x"), Values({0, 100}));
  EXPECT_EQ(plot::values_of(panel.traces.back(), "y"), Values({0.2, 0.15}));
  EXPECT_EQ(plot::values_of(panel.traces.front(), "y"), Values({0.2 - 2 * 0.01, 0.15 - 2 * 0.002}));
  EXPECT_EQ(plot::values_of(panel.traces.front(), "customdata"), Values({0.2 + 2 * 0.01, 0.15 + 2 * 0.002}));
}

// Every point of the 95 % ellipse lies where the quadratic form of the covariance is -2 ln 0.05.
TEST(ReportFigures, PairsLieInTheirRegions) {
  const ReportData data = sample::campaign();
  const Figure f = figure(campaign_figures(data), "corner");
  const fit::ParameterEstimate &a = data.fit.parameters[0], &b = data.fit.parameters[1];
  const double r = data.fit.correlation(1, 0);
  ASSERT_EQ(f.panels[3].traces[1]["name"], "95 % region");
  const DrawnPath outer = path_of(f.panels[3].traces[1]);
  for (std::size_t i = 0; i < outer.x.size(); ++i) {
    const double x = (outer.x[i] - a.estimate) / a.sd, y = (outer.y[i] - b.estimate) / b.sd;
    EXPECT_NEAR((x * x - 2 * r * x * y + y * y) / (1 - r * r), -2 * std::log(0.05), 1e-9);
  }
}

}  // namespace

}  // namespace tribotrack::apps
