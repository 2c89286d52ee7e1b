#include "apps/figures/figure_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "apps/text/csv_table.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

std::string at(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? exact(values[i]) : std::string();
}

}  // namespace

std::string csv_of(const Figure& figure) {
  std::string csv = "panel,series,mark,name,x,y,sd,y_high,note\n";
  for (std::size_t p = 0; p < figure.panels.size(); ++p)
    for (std::size_t s = 0; s < figure.panels[p].series.size(); ++s) {
      const Series& series = figure.panels[p].series[s];
      for (std::size_t i = 0; i < series.x.size(); ++i)
        csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", p + 1, s + 1, word_for(series.mark),
                           csv_cell(series.name), at(series.x, i), at(series.y, i), at(series.sd, i),
                           at(series.y_high, i), i < series.notes.size() ? csv_cell(series.notes[i]) : "");
    }
  return csv;
}

namespace {

constexpr int kDigits = 7;            // of what stands by itself
constexpr double kTellsApart = 1e-4;  // of an axis: a tenth of a pixel where it is a thousand long

Json short_number(double value, int digits = kDigits) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.{}g}", value, digits).c_str(), nullptr);
}

Json short_numbers(const std::vector<double>& values, int digits = kDigits) {
  Json list = Json::array();
  for (const double value : values) list.push_back(short_number(value, digits));
  return list;
}

/// Places along an axis, as fine as it can show.
Json places(const std::vector<double>& values, const FigureAxis& axis) {
  Json list = Json::array();
  const double step = kTellsApart * std::abs(axis.high - axis.low);
  for (const double value : values) {
    const bool plain = axis.scale == AxisScale::logarithmic || !(step > 0) || !std::isfinite(value);
    const double digits = plain ? kDigits : std::ceil(std::log10(std::max(std::abs(value) / step, 1.0))) + 1;
    list.push_back(short_number(value, static_cast<int>(std::clamp(digits, 1.0, 15.0))));
  }
  return list;
}

void add_ticks(const std::vector<double>& ticks, const std::vector<std::string>& labels, Json& json) {
  if (ticks.empty()) return;
  json["ticks"] = short_numbers(ticks);
  json["labels"] = labels;
}

Json axis_json(const FigureAxis& axis) {
  Json json = {{"title", axis.title}, {"low", short_number(axis.low)}, {"high", short_number(axis.high)}};
  if (axis.scale == AxisScale::logarithmic) json["log"] = true;
  add_ticks(axis.ticks, axis.labels, json);
  if (!axis.shown) json["hidden"] = true;
  return json;
}

Json series_json(const Series& series, const FigurePanel& panel) {
  Json json = {{"mark", word_for(series.mark)}, {"name", series.name}};
  if (std::isnan(series.value))
    json["colour"] = series.colour;
  else
    json["value"] = short_number(series.value);
  if (series.in_legend) json["in_legend"] = true;
  if (series.dashed) json["dashed"] = true;
  if (series.small) json["small"] = true;
  if (series.large) json["large"] = true;
  json["x"] = places(series.x, panel.x);
  json["y"] = places(series.y, panel.y);
  if (!series.sd.empty()) json["sd"] = short_numbers(series.sd, 3);
  if (!series.y_high.empty()) json["y_high"] = places(series.y_high, panel.y);
  if (!series.notes.empty()) json["notes"] = series.notes;
  return json;
}

Json panel_json(const FigurePanel& panel) {
  Json json = {{"x", axis_json(panel.x)}, {"y", axis_json(panel.y)}};
  if (!panel.title.empty()) json["title"] = panel.title;
  if (panel.height != 1) json["height"] = panel.height;
  if (panel.equal_scale) json["equal_scale"] = true;
  if (panel.zero_line) json["zero_line"] = true;
  for (const Stripe& stripe : panel.stripes) json["stripes"].push_back({stripe.low, stripe.high});
  for (const Stripe& span : panel.spans)
    json["spans"].push_back({short_number(span.low), short_number(span.high)});
  json["series"] = Json::array();
  for (const Series& series : panel.series) json["series"].push_back(series_json(series, panel));
  return json;
}

}  // namespace

const char* word_for(Mark mark) {
  switch (mark) {
    case Mark::points:
      return "points";
    case Mark::line:
      return "line";
    case Mark::band:
      return "band";
    case Mark::bars:
      return "bars";
    case Mark::text:
      return "text";
  }
  return "";
}

Json json_of(const Figure& figure) {
  Json json = {{"id", figure.id},
               {"title", figure.title},
               {"columns", figure.columns},
               {"height", figure.height},
               {"shared_x", figure.shared_x}};
  if (figure.width != 1) json["width"] = figure.width;
  if (figure.colours) {
    json["colours"] = {{"title", figure.colours->title},
                       {"low", short_number(figure.colours->low)},
                       {"high", short_number(figure.colours->high)}};
    add_ticks(figure.colours->ticks, figure.colours->labels, json["colours"]);
  }
  json["panels"] = Json::array();
  for (const FigurePanel& panel : figure.panels) json["panels"].push_back(panel_json(panel));
  return json;
}

}  // namespace tribotrack::apps
