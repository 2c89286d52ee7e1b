#include "apps/bench/figures/log_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/figures/axes.h"

namespace tribotrack::bench {

using namespace apps;

namespace {

constexpr double kMostDecades = 8;     // with a number each
constexpr double kPanelHeight = 0.56;  // over its width
constexpr double kRowHeight = 0.05;    // more for titles and numbers, over the width of the figure
const char* const kRing = "◯";

bool drawable(double value) {
  return std::isfinite(value) && value > 0;
}

/// "10⁻¹²"
std::string power_of_ten(long exponent) {
  static const char* const digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char c : std::to_string(std::abs(exponent))) text += digits[c - '0'];
  return text;
}

/// Whole decades around the values that can be drawn, numbered at least so far apart that they can be read.
FigureAxis decades(const std::string& title, const std::vector<double>& values) {
  FigurePanel panel;
  panel.x.scale = AxisScale::logarithmic;
  panel.series.push_back({});
  for (const double value : values)
    if (drawable(value)) panel.series.back().x.push_back(value);
  Figure figure;
  figure.panels.push_back(panel);
  settle_axes(figure);
  FigureAxis axis = figure.panels.front().x;
  axis.title = title;
  const long low = std::lround(std::log10(axis.low)), high = std::lround(std::log10(axis.high));
  const long step = std::max(1L, std::lround(std::ceil(static_cast<double>(high - low) / kMostDecades)));
  for (long k = low; k <= high; k += step) {
    axis.ticks.push_back(std::pow(10, static_cast<double>(k)));
    axis.labels.push_back(power_of_ten(k));
  }
  return axis;
}

/// The groups in the order of the legend: ours, then as they come.
std::vector<std::string> groups_of(const std::vector<LogLogPoint>& points) {
  std::vector<std::string> groups;
  for (const bool ours : {true, false})
    for (const LogLogPoint& point : points)
      if (point.ours == ours && std::ranges::find(groups, point.group) == groups.end())
        groups.push_back(point.group);
  return groups;
}

class Drawing {
 public:
  Drawing(const LogLogText& text, const std::vector<LogLogPoint>& points)
      : text_(text), groups_(groups_of(points)) {
    std::vector<double> x, y;
    for (const LogLogPoint& point : points) {
      x.push_back(point.x);
      y.push_back(drawable(point.x) ? point.y : kNone);
    }
    x_ = decades(text.x, x);
    y_ = decades(text.y, y);
    for (const LogLogPoint& point : points) add(point);
  }

  Figure figure() {
    const std::size_t count = panels_.size();
    const std::size_t columns = std::clamp<std::size_t>(count, 1, static_cast<std::size_t>(text_.columns));
    Figure figure{.id = text_.id, .title = text_.title, .caption = caption()};
    figure.columns = static_cast<int>(columns);
    figure.alternative = text_.title + ": " + std::to_string(count) + " panels over two logarithmic axes, " +
                         text_.x + " and " + text_.y;
    const double rows = std::ceil(static_cast<double>(count) / static_cast<double>(columns));
    figure.height = rows * (kPanelHeight / static_cast<double>(columns) + kRowHeight);
    for (std::size_t i = 0; i < count; ++i) {
      FigurePanel panel{.x = x_, .y = y_, .title = panels_[i].title};
      panel.x.shown = i + columns >= count;
      panel.y.shown = i % columns == 0;
      // Two numbers would meet where panels do.
      if ((i + 1) % columns != 0 && i + 1 < count && panel.x.ticks.back() >= panel.x.high)
        panel.x.labels.back().clear();
      for (auto* kind : {&panels_[i].lines, &panels_[i].marks, &panels_[i].rings})
        for (Series& series : *kind)
          if (series.mark != Mark::line || series.x.size() > 1) panel.series.push_back(std::move(series));
      figure.panels.push_back(std::move(panel));
    }
    return figure;
  }

 private:
  struct Panel {
    std::string title;
    std::vector<std::string> methods;
    std::vector<Series> lines = {}, marks = {};  ///< one each for a method
    std::vector<Series> rings = {};              ///< one, where a peer wins
  };

  void add(const LogLogPoint& point) {
    if (!drawable(point.x)) {
      ++without_x_;
      return;
    }
    Panel& panel = panel_of(point.panel);
    const std::size_t method = method_of(panel, point);
    const bool at_edge = !drawable(point.y);
    const double y = at_edge ? y_.low : point.y;
    at_edge_ += at_edge;
    for (Series* series : {&panel.lines[method], &panel.marks[method]}) {
      series->x.push_back(point.x);
      series->y.push_back(y);
    }
    panel.marks[method].notes.push_back(
        at_edge ? fmt::format("{}: {:g}, at the lower edge", point.note, point.y) : point.note);
    if (!point.peer_wins) return;
    ++wins_;
    if (panel.rings.empty())
      panel.rings.push_back({.mark = Mark::text, .name = "a peer wins", .colour = kInk});
    panel.rings.front().x.push_back(point.x);
    panel.rings.front().y.push_back(y);
    panel.rings.front().notes.emplace_back(kRing);
  }

  Panel& panel_of(const std::string& title) {
    const auto found = std::ranges::find(panels_, title, &Panel::title);
    if (found != panels_.end()) return *found;
    panels_.push_back({title, {}});
    return panels_.back();
  }

  std::size_t method_of(Panel& panel, const LogLogPoint& point) {
    const auto found = std::ranges::find(panel.methods, point.method);
    if (found != panel.methods.end()) return static_cast<std::size_t>(found - panel.methods.begin());
    const auto group = static_cast<std::size_t>(std::ranges::find(groups_, point.group) - groups_.begin());
    const bool named = groups_.size() <= kMostInLegend || group + 1 < kMostInLegend;
    Series series{.name = named ? point.group : "others", .colour = named ? static_cast<int>(group) : kGrey};
    series.dashed = point.dashed;
    series.small = !point.ours;
    series.mark = Mark::line;
    panel.lines.push_back(series);
    series.mark = Mark::points;
    series.small = false;
    series.large = point.ours;
    series.in_legend = std::ranges::find(in_legend_, series.name) == in_legend_.end();
    if (series.in_legend) in_legend_.push_back(series.name);
    panel.marks.push_back(series);
    panel.methods.push_back(point.method);
    return panel.methods.size() - 1;
  }

  std::string caption() const {
    std::string caption = text_.caption;
    if (wins_ > 0) caption += fmt::format(" A ring marks each of the {} points where a peer wins.", wins_);
    if (at_edge_ > 0)
      caption += fmt::format(" At the lower edge: {} with a value of 0 or none, which has no logarithm.",
                             at_edge_ == 1 ? "one point" : fmt::format("{} points", at_edge_));
    if (without_x_ > 0)
      caption += fmt::format(" Not drawn: {} without a place along the other axis.",
                             without_x_ == 1 ? "one point" : fmt::format("{} points", without_x_));
    return caption;
  }

  const LogLogText& text_;
  std::vector<std::string> groups_, in_legend_;
  FigureAxis x_, y_;
  std::vector<Panel> panels_;
  int wins_ = 0, at_edge_ = 0, without_x_ = 0;
};

}  // namespace

Figure log_log_figure(const LogLogText& text, const std::vector<LogLogPoint>& points) {
  return Drawing(text, points).figure();
}

}  // namespace tribotrack::bench
