#include "apps/report/page/first.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/page.h"
#include "apps/page/text.h"
#include "apps/report/findings/quoted.h"
#include "apps/report/page/pictures.h"
#include "apps/report/page/sections.h"

namespace tribotrack::apps {
namespace {

std::string result_table(const ReportData& data) {
  if (!data.fitted || data.parameters.empty()) return "";
  std::string html =
      "<table id=\"result\" class=\"result\"><thead><tr><th>Parameter</th><th>Value, and 95 % "
      "interval</th></tr></thead><tbody>\n";
  for (const ReportParameter& p : data.parameters) {
    const ParameterText shown = parameter_text(p.name);
    const bool determined = std::isfinite(p.estimate) && std::isfinite(p.sd);
    html += fmt::format(
        "<tr><th>{}</th><td class=\"value\" data-v=\"{}\">{}{}<br><span class=\"ends\">{}</span></td></tr>\n",
        shown.symbol, determined ? fmt::format("{}", p.estimate) : "", quoted_value(p.estimate, p.sd),
        shown.unit.empty() || !determined ? "" : " " + shown.unit, determined ? quoted_interval(p) : "");
  }
  return html +
         "</tbody></table>\n<p class=\"note\">In parentheses the standard deviation of the last "
         "digits.</p>\n";
}

}  // namespace

std::string first_figure(const std::vector<Figure>& figures) {
  for (const char* id : {"alpha-phi", "alpha-dtau", "trajectories", "slide-1"})
    if (std::ranges::find(figures, std::string(id), &Figure::id) != figures.end()) return id;
  return "";
}

std::string first_screen(const ReportData& data, const std::vector<Figure>& figures) {
  const std::string figure = figure_box(figures, first_figure(figures)), picture = first_picture(data);
  std::string html =
      verdict_box(data) + "<div class=\"first\">\n<div class=\"values\">" + result_table(data) + "</div>\n";
  if (!picture.empty()) html += "<div class=\"picture\">" + picture + "</div>\n";
  if (!figure.empty()) html += "<div class=\"seen\">" + figure + "</div>\n";
  return html + "</div>\n" + warning_box(data);
}

}  // namespace tribotrack::apps
