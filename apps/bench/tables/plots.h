// The panels and series of a benchmark's plot.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "apps/text/svg_plot.h"

namespace tribotrack::bench {

/// The panel called `title`, and in it the series called `name`; made where missing.
inline apps::PlotSeries& series_in(apps::LogLogPlot& plot, const std::string& title, const std::string& name,
                                   bool emphasised) {
  auto& panels = plot.panels;
  auto panel = std::ranges::find(panels, title, &apps::PlotPanel::title);
  if (panel == panels.end()) panel = panels.insert(panels.end(), {title, {}});
  auto series = std::ranges::find(panel->series, name, &apps::PlotSeries::name);
  if (series == panel->series.end())
    series = panel->series.insert(panel->series.end(), {name, {}, emphasised});
  return *series;
}

}  // namespace tribotrack::bench
