#include "apps/report/page/rotation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/report/data/path.h"
#include "apps/report/text/text.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t kMostPoints = 300;
constexpr double kTurns = 5;  ///< standard deviations: less may be chance
constexpr double kWidth = 320, kHeight = 140, kLeft = 46, kBelow = 30, kAbove = 8, kRight = 8;

struct Range {
  double low = 0, high = 0;
  double size() const { return high - low; }
};

Range range_of(const std::vector<double>& values) {
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const double v : values)
    if (std::isfinite(v)) range = {std::min(range.low, v), std::max(range.high, v)};
  return range;
}

bool turns(const ReportRun& run) {
  return run.failure.empty() && !run.theta_rad.empty() &&
         range_of(run.theta_rad).size() > kTurns * run.sigma_theta_rad;
}

std::string label(double x, double y, const char* anchor, const std::string& text) {
  return fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"{}\" font-size=\"11\">{}</text>", x, y,
                     anchor, text);
}

std::string figure(const ReportRun& run, std::size_t index) {
  const DrawnPath path = thinned(run.time_s, run.theta_rad, kMostPoints);
  const Range time = range_of(run.time_s), theta = range_of(run.theta_rad);
  const double bottom = kHeight - kBelow, right = kWidth - kRight;
  std::string commands;
  bool pen_down = false;
  for (std::size_t k = 0; k < path.x.size(); ++k) {
    const bool seen = std::isfinite(path.y[k]);
    if (seen)
      commands += fmt::format("{}{:.1f} {:.1f}", pen_down ? "L" : "M",
                              kLeft + (right - kLeft) * (path.x[k] - time.low) / std::max(1e-12, time.size()),
                              bottom - (bottom - kAbove) * (path.y[k] - theta.low) / theta.size());
    pen_down = seen;
  }
  return fmt::format(
             "<figure class=\"frame\"><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"rotation of {}\" "
             "style=\"background:none;cursor:auto\" "
             "fill=\"currentColor\"><path d=\"M{} {}V{}H{}\" fill=\"none\" stroke=\"currentColor\" "
             "opacity=\"0.5\"/><path d=\"{}\" fill=\"none\" stroke=\"currentColor\" stroke-width=\"1.5\"/>",
             kWidth, kHeight, escape_html(run.name), kLeft, kAbove, bottom, right, commands) +
         label(kLeft - 4, kAbove + 9, "end", number(theta.high, 3)) +
         label(kLeft - 4, bottom, "end", number(theta.low, 3)) +
         label(kLeft, kHeight - 16, "start", number(time.low, 3)) +
         label(right, kHeight - 16, "end", number(time.high, 3) + " s") +
         fmt::format("</svg><figcaption><b>{}</b> {}<br>θ in rad, sd {}</figcaption></figure>\n", index + 1,
                     escape_html(run.name), number(run.sigma_theta_rad, 2));
}

}  // namespace

std::string rotation_section(const ReportData& data) {
  std::string figures;
  for (std::size_t i = 0; i < data.runs.size(); ++i)
    if (turns(data.runs[i])) figures += figure(data.runs[i], i);
  if (figures.empty()) return "";
  return "<section id=\"rotation\"><h2>How the part turned</h2>\n<div class=\"frames\">\n" + figures +
         "</div>\n<p class=\"note\">Rotation since the first frame in which it is seen, counter-clockwise as "
         "the camera sees it, by the part’s own texture (column theta_rad of its track). A part that spins "
         "while it slides is braked less.</p>\n</section>\n";
}

}  // namespace tribotrack::apps
