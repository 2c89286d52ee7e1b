// A small log-log plot as SVG: error against run time.
#pragma once

#include <string>
#include <vector>

namespace tribotrack::apps {

struct PlotPoint {
  double x = 0, y = 0;
};

struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
  bool ours = false;  ///< drawn bolder, first in the colours
};

struct PlotPanel {
  std::string title;
  std::vector<PlotSeries> series;
};

/// Panels in two columns, axes of whole decades common to all. Points that are not positive and finite are
/// drawn at the lower edge (y) or left out (x).
std::string log_log_svg(const std::vector<PlotPanel>& panels, const std::string& x_label,
                        const std::string& y_label);

}  // namespace tribotrack::apps
