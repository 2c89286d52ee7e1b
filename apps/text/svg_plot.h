// Log-log plots as stand-alone SVG.
#pragma once

#include <string>
#include <vector>

namespace tribotrack::apps {

struct PlotPoint {
  double x = 0, y = 0;
};

/// Points joined by a line. Series of one name have one colour in all panels.
struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
  bool emphasised = false;  ///< larger dots, a thicker line
};

struct PlotPanel {
  std::string title;
  std::vector<PlotSeries> series;
};

struct LogLogPlot {
  std::vector<PlotPanel> panels;
  std::string x_label, y_label;
};

/// Panels in two columns, a legend below; the axes span whole decades and are the same in all panels. Points
/// with x <= 0 or not finite are left out; y <= 0 or not finite is drawn at the lower edge.
std::string svg_of(const LogLogPlot& plot);

}  // namespace tribotrack::apps
