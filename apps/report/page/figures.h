// The numbers behind the report's interactive figures, and the places on the page where they are drawn.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// A curve as plotted: nullopt breaks the line.
struct BrokenCurve {
  std::vector<std::optional<double>> x;
  std::vector<std::optional<double>> y;
};

/// A curve of an angle in [0, 2 pi) against x, broken where it runs through 0 / 2 pi (a step of more than
/// pi), so that no vertical line is drawn across the figure; the pieces are extended to the edge. Points that
/// are not finite break the line too.
BrokenCurve break_at_wraps(const std::vector<double>& x, const std::vector<double>& angle_rad);

/// What report.js draws, as JSON safe to stand inside a <script> element. Values are rounded to seven
/// significant digits; what is not finite is null.
std::string figures_json(const ReportData& data);

/// The figures' sections: captions, empty boxes for the plots, and a sentence for each figure that is left
/// out.
std::string dependence_section(const ReportData& data);  ///< figures 9a, 9b, 10
std::string trajectory_plot(const ReportData& data);     ///< figure 11, in millimetres
std::string residual_section(const ReportData& data);
std::string slide_section(const ReportData& data);

}  // namespace tribotrack::apps
