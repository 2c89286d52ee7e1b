#include "apps/report/page/platform.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/report/text/text.h"

namespace tribotrack::apps {
namespace {

constexpr double kWide = 300, kHigh = 200, kLeft = 46, kBottom = 34, kTop = 10, kRight = 10;
constexpr std::size_t kMostPoints = 1200;

struct Axis {
  double low = 0, high = 1;
};

Axis around(const std::vector<double>& a, const std::vector<double>& b = {}) {
  Axis axis{1e300, -1e300};
  for (const auto* values : {&a, &b})
    for (const double v : *values) {
      if (!std::isfinite(v)) continue;
      axis.low = std::min(axis.low, v);
      axis.high = std::max(axis.high, v);
    }
  if (axis.low > axis.high) return {};
  const double room = std::max(0.06 * (axis.high - axis.low), 1e-9);
  return {axis.low - room, axis.high + room};
}

/// A plain drawing: dots, a line over them, the two axes named and their ends numbered.
class Drawing {
 public:
  Drawing(Axis x, Axis y, const std::string& label) : x_(x), y_(y) {
    svg_ = fmt::format(
        "<svg class=\"plain\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" "
        "aria-label=\"{2}\"><rect x=\"{3}\" y=\"{4}\" width=\"{5}\" height=\"{6}\" fill=\"none\" "
        "stroke=\"#999\"/>",
        kWide, kHigh, escape_html(label), kLeft, kTop, kWide - kLeft - kRight, kHigh - kTop - kBottom);
  }
  void dots(const std::vector<double>& x, const std::vector<double>& y) {
    const std::size_t step = std::max<std::size_t>(1, x.size() / kMostPoints);
    svg_ += "<path fill=\"none\" stroke=\"#0072b2\" stroke-width=\"2\" stroke-linecap=\"round\" d=\"";
    for (std::size_t k = 0; k < x.size(); k += step)
      if (std::isfinite(x[k]) && std::isfinite(y[k]))
        svg_ += fmt::format("M{:.1f} {:.1f}h0", across(x[k]), down(y[k]));
    svg_ += "\"/>";
  }
  void line(const std::vector<double>& x, const std::vector<double>& y) {
    svg_ += "<path fill=\"none\" stroke=\"#d55e00\" stroke-width=\"1.2\" d=\"";
    for (std::size_t k = 0; k < x.size(); ++k)
      svg_ += fmt::format("{}{:.1f} {:.1f}", k == 0 ? "M" : "L", across(x[k]), down(y[k]));
    svg_ += "\"/>";
  }
  std::string done(const std::string& x_name, const std::string& y_name, int digits) const {
    const auto text = [](double x, double y, const char* anchor, const std::string& label) {
      return fmt::format(
          "<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"{}\" font-size=\"11\" fill=\"#444\">{}</text>", x, y,
          anchor, label);
    };
    const auto end = [&](double v) { return number(v, digits); };
    const double base = kHigh - kBottom;
    return svg_ + text(kLeft, base + 13, "start", end(x_.low)) +
           text(kWide - kRight, base + 13, "end", end(x_.high)) +
           text(0.5 * (kLeft + kWide - kRight), kHigh - 6, "middle", x_name) +
           text(kLeft - 4, base, "end", end(y_.low)) + text(kLeft - 4, kTop + 9, "end", end(y_.high)) +
           fmt::format(
               "<text transform=\"translate(12 {:.0f}) rotate(-90)\" text-anchor=\"middle\" "
               "font-size=\"11\" fill=\"#444\">{}</text>",
               0.5 * (kTop + base), y_name) +
           "</svg>";
  }

 private:
  double across(double x) const {
    return kLeft + (kWide - kLeft - kRight) * (x - x_.low) / (x_.high - x_.low);
  }
  double down(double y) const {
    return kHigh - kBottom - (kHigh - kTop - kBottom) * (y - y_.low) / (y_.high - y_.low);
  }
  Axis x_, y_;
  std::string svg_;
};

std::string orbit_drawing(const ReportPlatform& p) {
  Axis x = around(p.orbit_x_mm, p.model_x_mm), y = around(p.orbit_y_mm, p.model_y_mm);
  // One scale for both: a circle must look like one.
  const double per_px =
      std::max((x.high - x.low) / (kWide - kLeft - kRight), (y.high - y.low) / (kHigh - kTop - kBottom));
  const auto stretch = [&](Axis& a, double pixels) {
    const double middle = 0.5 * (a.low + a.high);
    a = {middle - 0.5 * pixels * per_px, middle + 0.5 * pixels * per_px};
  };
  stretch(x, kWide - kLeft - kRight);
  stretch(y, kHigh - kTop - kBottom);
  Drawing drawing(x, y, "the platform's orbit");
  drawing.dots(p.orbit_x_mm, p.orbit_y_mm);
  drawing.line(p.model_x_mm, p.model_y_mm);
  return drawing.done("ξ, mm", "η, mm", 3);
}

std::string phase_drawing(const ReportPlatform& p) {
  Axis y = around(p.phase_left_mrad);
  y = {std::min(y.low, 0.0), std::max(y.high, 0.0)};
  const Axis x = around(p.time_s);
  Drawing drawing(x, y, "phase residual over time");
  drawing.dots(p.time_s, p.phase_left_mrad);
  drawing.line({x.low, x.high}, {0, 0});
  return drawing.done("time, s", "phase residual, mrad", 3);
}

std::string gate_drawing(const ReportPlatform& p) {
  Drawing drawing({0, 2 * std::numbers::pi}, {-0.1, 1.1}, "the lamp's brightness by the platform's phase");
  drawing.dots(p.gate_phase_rad, p.gate_share);
  drawing.line(p.gate_model_phase_rad, p.gate_model_share);
  return drawing.done("ωt, rad", "lit share", 3);
}

std::string with_sd(const char* symbol, double value, double sd, const char* unit) {
  return std::isnan(value) ? "" : fmt::format("{} = {} {}", symbol, value_and_sd(value, sd), unit);
}

std::string numbers(const ReportRun& run) {
  const ReportPlatform& p = run.platform;
  std::vector<std::string> parts;
  const auto add = [&](const std::string& text) {
    if (!text.empty()) parts.push_back(text);
  };
  add(with_sd("A", p.amplitude_mm, p.amplitude_sd_mm, "mm"));
  add(with_sd("A<sub>y</sub>", p.amplitude_y_mm, p.amplitude_y_sd_mm, "mm"));
  add(with_sd("ω", p.w_rad_s, p.w_sd_rad_s, "rad/s"));
  add(with_sd("ε", p.epsilon_rad, p.epsilon_sd_rad, "rad"));
  add(with_sd("dω/dt", p.drift_rad_s2, p.drift_sd_rad_s2, "rad/s²"));
  for (const ReportHarmonic& h : p.harmonics)
    add(fmt::format("{}ω: {} mm along x, {} mm along y", h.order,
                    value_and_sd(h.amplitude_mm, h.amplitude_sd_mm),
                    value_and_sd(h.amplitude_y_mm, h.amplitude_y_sd_mm)));
  add(with_sd("φ", p.phi_rad, p.phi_sd_rad, "rad"));
  add(with_sd("Δτ", p.dtau_rad, p.dtau_sd_rad, "rad"));
  if (!p.gate_source.empty()) add("gate from the " + escape_html(p.gate_source));
  return fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace

std::string platform_section(const ReportData& data) {
  std::string html;
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    const ReportRun& run = data.runs[i];
    if (run.platform.orbit_x_mm.empty()) continue;
    html += fmt::format("<details{}><summary>{} {}: {}</summary>\n<div class=\"drawings\">",
                        html.empty() ? " open" : "", i + 1, escape_html(run.name), numbers(run));
    html += orbit_drawing(run.platform) + phase_drawing(run.platform);
    if (!run.platform.gate_share.empty()) html += gate_drawing(run.platform);
    html += "</div></details>\n";
  }
  if (html.empty()) return "";
  std::string text =
      "<p class=\"note\">Dots: frames; lines: the motion fitted to all of them, with the values above each "
      "drawing. Left: the platform’s orbit. Middle: phase residual of a constant frequency; a bend is a "
      "drift "
      "of the drive. Right, with a lamp in the picture: its brightness over the platform’s phase; the slopes "
      "are exposures during which the lamp switched.</p>\n";
  if (!data.phase_reference.empty()) text += "<p>" + sentence_html(data.phase_reference) + "</p>\n";
  return "<section id=\"platform\"><h2>Platform and gate, as measured</h2>\n" + text + html + "</section>\n";
}

}  // namespace tribotrack::apps
