// Traces, axes and shapes: how a figure looks (namespace plot of figure.h).
#include "apps/figures/figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tribotrack::apps {

namespace {

constexpr double kPi = std::numbers::pi;

// Okabe and Ito's colours, distinct to colour-blind eyes; symbols and dashes carry the same without colour.
// Those of the page's light theme: figures.js knows what each is on a dark screen.
constexpr std::array kColours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                 "#e69f00", "#56b4e9", "#7f7f7f", "#8a5f00"};
constexpr std::array kSymbols = {"circle", "square", "diamond", "triangle-up",
                                 "x",      "cross",  "star",    "hexagon"};
constexpr const char *kInkColour = "#1a1a1a", *kGreyColour = "#666666", *kPaper = "#ffffff",
                     *kStripe = "#ededed";
constexpr const char *kFaded = "38", *kFainter = "2e";  // behind six digits of a colour: 0.22, 0.18

/// Cividis.
constexpr std::array<std::array<int, 3>, 5> kRamp = {
    {{0x00, 0x22, 0x4e}, {0x35, 0x45, 0x6c}, {0x7c, 0x7b, 0x78}, {0xbc, 0xaf, 0x6f}, {0xfe, 0xe8, 0x38}}};

std::string on_ramp(double share) {
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(kRamp.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(place), kRamp.size() - 2);
  std::string colour = "#";
  for (std::size_t c = 0; c < 3; ++c)
    colour += fmt::format(
        "{:02x}", std::lround(std::lerp(kRamp[k][c], kRamp[k + 1][c], place - static_cast<double>(k))));
  return colour;
}

bool ramped(const plot::Look& look) {
  return !std::isnan(look.on_ramp);
}

std::string colour_of(const plot::Look& look) {
  if (ramped(look)) return on_ramp(look.on_ramp);
  if (look.colour == plot::kInk) return kInkColour;
  if (look.colour == plot::kGrey) return kGreyColour;
  return kColours[static_cast<std::size_t>(look.colour) % kColours.size()];
}

Json trace(const std::string& name, const Values& x, const Values& y, const plot::Look& look) {
  Json json = {{"name", name}, {"showlegend", look.legend}, {"x", x}, {"y", y}};
  if (!name.empty()) json["legendgroup"] = name;
  return json;
}

std::string hover_text(const std::string& name, const std::string& places) {
  return (name.empty() ? "" : name + "<br>") + places + "<extra></extra>";
}

}  // namespace

namespace plot {

Json points(const std::string& name, const Values& x, const Values& y, const Look& look, const Notes& notes,
            const Values& sd) {
  const bool dots = look.small || ramped(look);
  Json json = trace(name, x, y, look);
  json["mode"] = "markers";
  json["marker"] = {
      {"color", colour_of(look)},
      {"symbol", kSymbols[look.colour < 0 ? 0 : static_cast<std::size_t>(look.colour) % kSymbols.size()]},
      {"size", look.small     ? 3
               : ramped(look) ? 5
               : look.large   ? 11
                              : 7.5},
      {"line", {{"color", kPaper}, {"width", dots ? 0 : 0.8}}}};
  json["hovertemplate"] =
      hover_text(notes.empty() ? name : "%{text}",
                 sd.empty() ? "%{x:.5g}, %{y:.5g}" : "%{x:.5g}, %{y:.5g} ± %{customdata:.2g}");
  if (!notes.empty()) json["text"] = notes;
  if (!sd.empty())
    json["error_y"] = {{"type", "data"},
                       {"array", sd},
                       {"color", colour_of(look)},
                       {"thickness", look.small ? 0.7 : 1.3},
                       {"width", look.small ? 0 : 3}};
  return json;
}

Json line(const std::string& name, const Values& x, const Values& y, const Look& look) {
  Json json = trace(name, x, y, look);
  json["mode"] = "lines";
  json["hovertemplate"] = hover_text(name, "%{x:.5g}, %{y:.5g}");
  json["line"] = {{"color", colour_of(look)},
                  {"width", look.small || ramped(look) ? 1.1 : 1.9},
                  {"dash", look.dashed ? "dash" : "solid"},
                  {"simplify", false}};
  return json;
}

Json band(const std::string& name, const Values& x, const Values& low, const Values& high, const Look& look) {
  Json json = trace(name, x, low, look);
  json["mode"] = "lines";
  json["fill"] = "toself";  // the page closes the outline along the upper edge
  json["customdata"] = high;
  json["fillcolor"] = colour_of(look) + kFaded;
  json["line"] = {{"width", 0}, {"color", colour_of(look)}};
  json["hoverinfo"] = "skip";
  return json;
}

Json labels(const Values& x, const Values& y, const Notes& notes) {
  Json json = trace("", x, y, {});
  json.update({{"mode", "text"}, {"text", notes}, {"hoverinfo", "skip"}, {"cliponaxis", false}});
  json["textfont"] = {{"color", kInkColour}, {"size", 12}, {"weight", "bold"}};
  return json;
}

Json end_numbers(const std::vector<Json>& paths, const Notes& numbers) {
  Range reach{HUGE_VAL, -HUGE_VAL};
  for (const Json& path : paths)
    for (const char* key : {"x", "y"}) reach = hull(reach, range_of(values_of(path, key)));
  Values xs, ys;
  Notes texts;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const Values x = values_of(paths[k], "x"), y = values_of(paths[k], "y");
    std::size_t end = x.size();
    while (end > 0 && !(std::isfinite(x[end - 1]) && std::isfinite(y[end - 1]))) --end;
    if (end == 0) continue;
    const double length = std::hypot(x[end - 1], y[end - 1]);
    const double out = length > 0 ? 1 + 0.05 * reach.size() / length : 1;
    std::size_t same = 0;
    while (same < xs.size() &&
           std::hypot(xs[same] - out * x[end - 1], ys[same] - out * y[end - 1]) > 0.03 * reach.size())
      ++same;
    if (same < xs.size()) {
      texts[same] += ", " + numbers[k];
      continue;
    }
    xs.push_back(out * x[end - 1]);
    ys.push_back(out * y[end - 1]);
    texts.push_back(numbers[k]);
  }
  return labels(xs, ys, texts);
}

Values values_of(const Json& trace, const char* key) {
  return trace.at(key).get<Values>();
}

Json axis(const std::string& title, double low, double high) {
  return {{"title", {{"text", title}}}, {"range", {low, high}}};
}

Json log_axis(const std::string& title, double low, double high) {
  Json json = axis(title, low, high);
  json["type"] = "log";
  return json;
}

Json with_ticks(Json axis, const Values& places, const Notes& texts) {
  axis["tickmode"] = "array";
  axis["tickvals"] = places;
  axis["ticktext"] = texts;
  return axis;
}

Json with_zero_line(Json axis) {
  axis["zeroline"] = true;
  return axis;
}

Json hidden(Json axis) {
  axis["showticklabels"] = false;
  return axis;
}

namespace {

/// Do all values lie on multiples of pi/n?
bool lie_on(const Values& values, long n) {
  return std::ranges::all_of(values, [&](double v) {
    const double k = v * static_cast<double>(n) / kPi;
    return !std::isfinite(v) || std::abs(k - std::round(k)) < 1e-3;
  });
}

}  // namespace

Json angle_axis(const std::string& title, double low, double high, const Values& values) {
  constexpr double kMostTicks = 8.5;
  constexpr std::array<long, 5> quarters = {12, 8, 4, 2, 1};
  constexpr std::array<long, 5> thirds = {12, 6, 3, 2, 1};
  const double turns = (high - low) / kPi;
  Values ticks;
  Notes texts;
  for (const long n : lie_on(values, 4) || !lie_on(values, 6) ? quarters : thirds) {
    if (turns * static_cast<double>(n) > kMostTicks && n > 1) continue;
    const double step = kPi / static_cast<double>(n);
    for (long k = std::lround(std::ceil(low / step - 1e-9)); static_cast<double>(k) * step <= high + 1e-9;
         ++k) {
      ticks.push_back(static_cast<double>(k) * step);
      texts.push_back(multiple_of_pi(k, n));
    }
    break;
  }
  const Json plain = axis(title, low, high);
  return ticks.size() < 3 ? plain : with_ticks(plain, ticks, texts);
}

namespace {

Json rectangle(const char* xref, double x0, double x1, const char* yref, double y0, double y1,
               const std::string& colour) {
  Json json = {{"type", "rect"}, {"layer", "below"}, {"xref", xref}, {"yref", yref}, {"fillcolor", colour}};
  json.update({{"x0", x0}, {"x1", x1}, {"y0", y0}, {"y1", y1}, {"line", {{"width", 0}}}});
  return json;
}

}  // namespace

Json stripe(double low, double high) {
  return rectangle("x domain", 0, 1, "y", low, high, kStripe);
}

Json span(double low, double high) {
  return rectangle("x", low, high, "y domain", 0, 1, std::string(kColours[1]) + kFainter);
}

Json colour_bar(const std::string& title, const Json& ticks) {
  Json bar =
      Json::parse(R"({"orientation": "h", "title": {"side": "top", "font": {"size": 12}}, "thickness": 10,
                             "len": 0.8, "x": 0.5, "y": 0, "yanchor": "top", "ypad": 6, "outlinewidth": 0})");
  bar["title"]["text"] = title;
  for (const char* key : {"tickvals", "ticktext"})
    if (ticks.contains(key)) bar[key] = ticks[key];
  Json json = Json::parse(R"({"x": [null], "y": [null], "mode": "markers", "showlegend": false,
                              "hoverinfo": "skip", "marker": {"showscale": true, "colorscale": []}})");
  Json& marker = json["marker"];
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0})
    marker["colorscale"].push_back({share, on_ramp(share)});
  marker["colorbar"] = bar;
  marker["cmin"] = marker["color"][0] = ticks.at("range")[0];
  marker["cmax"] = ticks.at("range")[1];
  return json;
}

}  // namespace plot

}  // namespace tribotrack::apps
