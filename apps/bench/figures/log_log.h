// Methods compared over two logarithmic axes, panel by panel.
#pragma once

#include <string>
#include <vector>

#include "apps/figures/figure.h"

namespace tribotrack::bench {

/// One method at one setting. Points with x <= 0 or not finite are left out; y <= 0 or not finite is drawn at
/// the lower edge. Both are said in the caption.
struct LogLogPoint {
  std::string panel;   ///< its title
  std::string method;  ///< its points are joined in their order
  std::string group;   ///< entry of the legend, with one colour in all panels
  std::string note;    ///< what the point is
  double x = 0, y = 0;
  bool ours = false;       ///< emphasised
  bool peer_wins = false;  ///< ringed
  bool dashed = false;
};

struct LogLogText {
  std::string id, title;
  std::string caption;  ///< HTML
  std::string x, y;     ///< the axes' titles
  int columns = 2;      ///< of panels, at most
};

/// All panels have the same axes, which end at whole decades. Groups beyond the legend's room are "others".
apps::Figure log_log_figure(const LogLogText& text, const std::vector<LogLogPoint>& points);

}  // namespace tribotrack::bench
