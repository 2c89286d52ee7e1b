#include "apps/text/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tribotrack::apps {

namespace {

constexpr double kWidth = 460, kHeight = 330, kLeft = 70, kRight = 15, kTop = 34, kBottom = 46;
constexpr double kLegendRow = 18;
// The colours of Okabe and Ito, distinguishable with every kind of colour vision.
constexpr std::array kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                              "#e69f00", "#56b4e9", "#000000", "#999999"};

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

bool drawable(double v) {
  return std::isfinite(v) && v > 0;
}

/// Whole decades around the data.
struct Decades {
  double low = 1e300, high = -1e300;
  void take(double v) {
    if (!drawable(v)) return;
    low = std::min(low, std::floor(std::log10(v)));
    high = std::max(high, std::ceil(std::log10(v)));
  }
  void complete() {
    if (low > high) low = 0, high = 1;
    if (low == high) high += 1;
  }
  double share(double v) const { return drawable(v) ? (std::log10(v) - low) / (high - low) : 0; }
};

class Page {
 public:
  explicit Page(const LogLogPlot& plot)
      : panels_(plot.panels), x_label_(plot.x_label), y_label_(plot.y_label) {
    for (const auto& panel : panels_)
      for (const auto& series : panel.series) {
        if (std::find(names_.begin(), names_.end(), series.name) == names_.end())
          names_.push_back(series.name);
        for (const auto& point : series.points) {
          x_.take(point.x);
          y_.take(point.y);
        }
      }
    x_.complete();
    y_.complete();
  }

  std::string svg() const {
    const auto rows = (panels_.size() + 1) / 2;
    const double width = panels_.size() > 1 ? 2 * kWidth : kWidth;
    const double legend = kLegendRow * static_cast<double>(names_.size()) + 12;
    const double height = kHeight * static_cast<double>(rows) + legend;
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
        width, height);
    for (std::size_t k = 0; k < panels_.size(); ++k)
      out += panel(panels_[k], kWidth * static_cast<double>(k % 2), kHeight * static_cast<double>(k / 2));
    for (std::size_t k = 0; k < names_.size(); ++k) {
      const double y = kHeight * static_cast<double>(rows) + kLegendRow * (static_cast<double>(k) + 0.5);
      out += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"5\" fill=\"{}\"/>", kLeft, y, colour(names_[k]));
      out += fmt::format("<text x=\"{}\" y=\"{}\">{}</text>\n", kLeft + 14, y + 4, escaped(names_[k]));
    }
    return out + "</svg>\n";
  }

 private:
  std::string colour(const std::string& name) const {
    const auto place =
        static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name) - names_.begin());
    return kColours[place % kColours.size()];
  }
  double across(double x0, double v) const { return x0 + kLeft + x_.share(v) * (kWidth - kLeft - kRight); }
  double down(double y0, double v) const {
    return y0 + kHeight - kBottom - y_.share(v) * (kHeight - kTop - kBottom);
  }

  std::string panel(const PlotPanel& panel, double x0, double y0) const {
    const double bottom = y0 + kHeight - kBottom;
    std::string out = fmt::format("<text x=\"{}\" y=\"{}\" font-weight=\"bold\">{}</text>\n", x0 + kLeft,
                                  y0 + 22, escaped(panel.title));
    const double y_step = std::max(1.0, std::ceil((y_.high - y_.low) / 9));
    for (double d = x_.low; d <= x_.high; d += 1) {
      const double x = across(x0, std::pow(10, d));
      out += fmt::format(
          "<path d=\"M{0} {1}V{2}\" stroke=\"#ddd\"/><text x=\"{0}\" y=\"{3}\" "
          "text-anchor=\"middle\">1e{4:g}</text>\n",
          x, y0 + kTop, bottom, bottom + 16, d);
    }
    for (double d = y_.low; d <= y_.high; d += y_step) {
      const double y = down(y0, std::pow(10, d));
      out += fmt::format(
          "<path d=\"M{0} {1}H{2}\" stroke=\"#ddd\"/><text x=\"{3}\" y=\"{4}\" "
          "text-anchor=\"end\">1e{5:g}</text>\n",
          x0 + kLeft, y, x0 + kWidth - kRight, x0 + kLeft - 6, y + 4, d);
    }
    out += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                       x0 + (kLeft + kWidth - kRight) / 2, bottom + 34, escaped(x_label_));
    const double middle = y0 + (kTop + kHeight - kBottom) / 2;
    out += fmt::format("<text transform=\"translate({},{}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                       x0 + 16, middle, escaped(y_label_));
    for (const auto& series : panel.series) {
      std::string path;
      for (const auto& point : series.points) {
        if (!drawable(point.x)) continue;
        const double x = across(x0, point.x), y = down(y0, point.y);
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x, y);
        out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\"/>", x, y,
                           series.emphasised ? 4 : 3, colour(series.name));
      }
      out += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>\n",
                         path.empty() ? "M0 0" : path, colour(series.name), series.emphasised ? 2.5 : 1.2);
    }
    return out;
  }

  const std::vector<PlotPanel>& panels_;
  const std::string &x_label_, &y_label_;
  std::vector<std::string> names_;
  Decades x_, y_;
};

}  // namespace

std::string svg_of(const LogLogPlot& plot) {
  return Page(plot).svg();
}

}  // namespace tribotrack::apps
