#include "apps/figures/figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <numeric>

namespace tribotrack::apps {

std::string multiple_of_pi(long k, long n) {
  if (k == 0) return "0";
  const long divisor = std::gcd(k, n), top = std::abs(k) / divisor, bottom = n / divisor;
  return (k < 0 ? "−" : "") + (top == 1 ? std::string() : std::to_string(top)) + "π" +
         (bottom == 1 ? std::string() : "/" + std::to_string(bottom));
}

Range range_of(const Values& values) {
  Range range{HUGE_VAL, -HUGE_VAL};
  for (const double value : values)
    if (std::isfinite(value)) range = {std::min(range.low, value), std::max(range.high, value)};
  if (range.low > range.high) return {};
  if (!(range.high > range.low)) range.high = range.low + std::max(std::abs(range.low), 1e-3);
  return range;
}

Range padded(const Range& range, double share) {
  return {range.low - share * range.size(), range.high + share * range.size()};
}

Range hull(const Range& a, const Range& b) {
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

namespace {

bool is_log(const Json& axis) {
  return axis.contains("type");
}

/// All that the traces of a panel reach along one axis.
Values reach(const Panel& panel, bool along_x) {
  Values all;
  for (const Json& trace : panel.traces) {
    const Values values = plot::values_of(trace, along_x ? "x" : "y");
    all.insert(all.end(), values.begin(), values.end());
    if (!along_x && trace.contains("fill")) {
      const Values high = plot::values_of(trace, "customdata");
      all.insert(all.end(), high.begin(), high.end());
    }
    if (along_x || !trace.contains("error_y")) continue;
    const Values sd = plot::values_of(trace["error_y"], "array");
    for (std::size_t i = 0; i < sd.size(); ++i)
      if (std::isfinite(sd[i])) all.insert(all.end(), {values[i] - sd[i], values[i] + sd[i]});
  }
  return all;
}

void settle(Json& axis, Values values) {
  if (is_log(axis))
    for (double& value : values) value = value > 0 ? std::log10(value) : kNone;
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  Range ends;
  if (!values.empty()) ends = {std::ranges::min(values), std::ranges::max(values)};
  if (is_log(axis)) {
    ends = {std::floor(ends.low + 1e-9), std::ceil(ends.high - 1e-9)};
    if (!(ends.high > ends.low)) ends.high = ends.low + 1;
  } else {
    const double spare = ends.high > ends.low ? 0 : std::max(0.5 * std::abs(ends.low), 1e-9);
    ends = padded({ends.low - spare, ends.high + spare}, 0.05);
  }
  Json& range = axis["range"];
  if (std::isnan(range[0].get<double>())) range[0] = ends.low;
  if (std::isnan(range[1].get<double>())) range[1] = ends.high;
}

}  // namespace

void settle_axes(Figure& figure) {
  const auto columns = static_cast<std::size_t>(figure.columns);
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    Panel& panel = figure.panels[i];
    if (panel.traces.empty()) continue;
    Values y = reach(panel, false), x;
    for (const Json& shape : panel.shapes)
      if (shape["yref"] == "y") y.insert(y.end(), {shape["y0"].get<double>(), shape["y1"].get<double>()});
    if (panel.y.contains("zeroline")) y.push_back(0);
    settle(panel.y, y);
    for (std::size_t k = 0; k < figure.panels.size(); ++k)
      if (k == i || (figure.shared_x && k % columns == i % columns)) {
        const Values more = reach(figure.panels[k], true);
        x.insert(x.end(), more.begin(), more.end());
      }
    settle(panel.x, x);
  }
}

AngleCurve broken_at_turns(const Values& x, const Values& y, const Values& half) {
  constexpr double turn = 2 * std::numbers::pi;
  AngleCurve curve;
  const auto add = [&](double at, double value, std::size_t i) {
    curve.x.push_back(at);
    curve.y.push_back(value);
    curve.half.push_back(std::isnan(value) || i >= half.size() ? kNone : half[i]);
  };
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i > 0 && std::abs(y[i] - y[i - 1]) > std::numbers::pi) {
      // Upwards through 2 pi, or downwards through 0: where along x, on the straight line between the two.
      const bool upwards = y[i] < y[i - 1];
      const double to = y[i] + (upwards ? turn : -turn), edge = upwards ? turn : 0;
      const double share = to == y[i - 1] ? 1 : (edge - y[i - 1]) / (to - y[i - 1]);
      const double at = x[i - 1] + share * (x[i] - x[i - 1]);
      add(at, edge, i);
      add(at, kNone, i);
      add(at, turn - edge, i);
    }
    add(x[i], y[i], i);
  }
  return curve;
}

DrawnPath thinned(const Values& x, const Values& y, std::size_t most) {
  const std::size_t count = std::min(x.size(), y.size());
  const std::size_t step = std::max<std::size_t>(1, (count + most - 1) / most);
  DrawnPath path;
  const auto add = [&](double px, double py) {
    path.x.push_back(px);
    path.y.push_back(py);
  };
  bool gap = false;
  for (std::size_t i = 0; i < count; ++i) {
    const bool measured = std::isfinite(x[i]) && std::isfinite(y[i]);
    gap = gap || !measured;
    if (i % step != 0) continue;
    if (gap) add(kNone, kNone);
    if (measured) add(x[i], y[i]);
    gap = false;
  }
  return path;
}

std::vector<std::size_t> envelope(const Values& y, std::size_t most) {
  std::vector<std::size_t> places;
  if (y.size() <= most) {
    places.resize(y.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    return places;
  }
  const std::size_t stretches = std::max<std::size_t>(1, most / 2);
  for (std::size_t k = 0; k < stretches; ++k) {
    const std::size_t begin = k * y.size() / stretches, end = (k + 1) * y.size() / stretches;
    std::size_t lowest = begin, highest = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(y[i])) continue;
      if (!std::isfinite(y[lowest]) || y[i] < y[lowest]) lowest = i;
      if (!std::isfinite(y[highest]) || y[i] > y[highest]) highest = i;
    }
    places.push_back(std::min(lowest, highest));
    if (lowest != highest) places.push_back(std::max(lowest, highest));
  }
  return places;
}

Values picked(const Values& values, const std::vector<std::size_t>& places) {
  Values chosen;
  chosen.reserve(places.size());
  for (const std::size_t place : places) chosen.push_back(place < values.size() ? values[place] : kNone);
  return chosen;
}

namespace {

void shorten(Json& number, int digits = 9) {
  const double value = number.is_number() ? number.get<double>() : kNone;
  number = std::isfinite(value) ? Json(std::strtod(fmt::format("{:.{}g}", value, digits).c_str(), nullptr))
                                : Json();
}

/// To a ten-thousandth of their range, a tenth of a pixel; on a logarithmic axis to seven digits.
void shorten_places(Json& numbers, const Json& axis) {
  const double step = 1e-4 * range_of(numbers.get<Values>()).size();
  for (Json& number : numbers) {
    const double size = std::abs(number.get<double>());
    const bool plain = is_log(axis) || !std::isfinite(size);
    shorten(number, plain ? 7 : 1 + static_cast<int>(std::ceil(std::log10(std::max(size / step, 1.0)))));
  }
}

Json shortened(Json trace, const Panel& panel) {
  shorten_places(trace["x"], panel.x);
  shorten_places(trace["y"], panel.y);
  if (trace.contains("fill")) shorten_places(trace["customdata"], panel.y);
  if (trace.contains("error_y"))
    for (Json& sd : trace["error_y"]["array"]) shorten(sd, 3);
  return trace;
}

Json shortened(Json axis) {
  for (const char* key : {"range", "tickvals"})
    if (axis.contains(key))
      for (Json& number : axis[key]) shorten(number);
  return axis;
}

/// Of the axes of panel `i`: "" for the first, "2", ...
std::string axis_number(std::size_t i) {
  return i == 0 ? "" : std::to_string(i + 1);
}

}  // namespace

Json plotly_json(const Figure& figure) {
  Json json = {{"id", figure.id},         {"title", figure.title}, {"columns", figure.columns},
               {"height", figure.height}, {"width", figure.width}, {"shared_x", figure.shared_x},
               {"panels", Json::array()}, {"data", Json::array()}, {"layout", {{"shapes", Json::array()}}}};
  std::vector<std::string> first(static_cast<std::size_t>(figure.columns), "none");  // axes of a column
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const Panel& panel = figure.panels[i];
    json["panels"].push_back({{"title", panel.title}, {"height", panel.height}});
    if (panel.traces.empty()) continue;
    const std::string n = axis_number(i);
    Json x = shortened(panel.x), y = shortened(panel.y);
    x["anchor"] = "y" + n;
    y["anchor"] = "x" + n;
    if (panel.equal_scale) y.update({{"scaleanchor", "x" + n}, {"scaleratio", 1}});
    std::string& column = first[i % first.size()];
    if (column == "none")
      column = n;
    else if (figure.shared_x)
      x["matches"] = "x" + column;
    json["layout"]["xaxis" + n] = x;
    json["layout"]["yaxis" + n] = y;
    for (Json shape : panel.shapes) {
      for (const char* key : {"xref", "yref"}) shape[key] = shape[key].get<std::string>().insert(1, n);
      for (const char* key : {"x0", "x1", "y0", "y1"}) shorten(shape[key]);
      json["layout"]["shapes"].push_back(shape);
    }
    for (const Json& trace : panel.traces) {
      Json& drawn = json["data"].emplace_back(shortened(trace, panel));
      drawn.update({{"xaxis", "x" + n}, {"yaxis", "y" + n}});
    }
  }
  if (!figure.colour_bar.is_null()) json["data"].push_back(figure.colour_bar);
  return json;
}

}  // namespace tribotrack::apps
