#include "apps/report/page/parameters/intervals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/page/text.h"
#include "apps/report/findings/quoted.h"

namespace tribotrack::apps {
namespace {

/// One way to an interval, shown where any parameter has it.
struct IntervalColumn {
  const char* heading;
  ReportInterval ReportParameter::*interval;
};

std::vector<IntervalColumn> interval_columns(const ReportData& data) {
  std::vector<IntervalColumn> columns = {{"95 % interval", &ReportParameter::ci95},
                                         {"by covariance", &ReportParameter::covariance_ci95},
                                         {"by profile", &ReportParameter::profile_ci95},
                                         {"by bootstrap", &ReportParameter::bootstrap_ci95}};
  std::erase_if(columns, [&](const IntervalColumn& column) {
    return std::all_of(data.parameters.begin(), data.parameters.end(), [&](const ReportParameter& p) {
      return std::isnan((p.*column.interval).low) || std::isnan((p.*column.interval).high);
    });
  });
  return columns;
}

bool has_column(const std::vector<IntervalColumn>& columns, ReportInterval ReportParameter::*interval) {
  return std::any_of(columns.begin(), columns.end(),
                     [&](const IntervalColumn& column) { return column.interval == interval; });
}

/// What each interval shown is, and which covariance stands behind the first.
std::string interval_note(const ReportData& data, const std::vector<IntervalColumn>& columns) {
  const bool profile = has_column(columns, &ReportParameter::profile_ci95);
  std::string html =
      profile
          ? "<p class=\"note\">The 95 % interval is the one to quote: the profile’s where it differs from "
            "the "
            "covariance’s by more than a tenth, over all minima that the data allow. The covariance interval "
            "assumes that χ² is a parabola about its minimum; the profile follows χ² itself, with all other "
            "parameters fitted again at every step"
          : "<p class=\"note\">The 95 % interval comes from the fit’s covariance, assuming that χ² is a "
            "parabola about its minimum";
  if (has_column(columns, &ReportParameter::bootstrap_ci95))
    html += fmt::format("; the bootstrap interval holds 95 % of {} refits to simulated data (seed {})",
                        data.bootstrap_refits, data.bootstrap_seed);
  html += ".</p>\n";
  if (!data.covariance_meaning.empty())
    html += "<p class=\"note\"><b>Which covariance this is:</b> " + sentence_html(data.covariance_meaning) +
            "</p>\n";
  return html;
}

}  // namespace

std::string interval_table(const ReportData& data) {
  const std::vector<IntervalColumn> columns = interval_columns(data);
  std::string html = fmt::format(
      "<div class=\"wide\"><table id=\"parameter-table\" "
      "class=\"parameters{}\"><thead><tr><th>Parameter</th><th "
      "class=\"n\">Value (sd of the last digits)</th>",
      columns.size() > 2 ? " many" : "");
  for (const IntervalColumn& column : columns) html += fmt::format("<th class=\"n\">{}</th>", column.heading);
  html += "<th>Unit</th><th>What it is</th></tr></thead><tbody>\n";
  for (const ReportParameter& p : data.parameters) {
    const ParameterText shown = parameter_text(p.name);
    html += "<tr><th>" + shown.symbol + "</th>" +
            (std::isfinite(p.sd) ? quoted_cell(p.estimate, p.sd) : number_cell("not determined"));
    for (const IntervalColumn& column : columns)
      html += "<td class=\"n ends\">" +
              (column.interval == &ReportParameter::ci95
                   ? quoted_interval(p)
                   : interval_text((p.*column.interval).low, (p.*column.interval).high, p.sd)) +
              "</td>";
    html += cell(shown.unit.empty() ? "1" : shown.unit) + cell(shown.meaning) + "</tr>\n";
  }
  return html + "</tbody></table></div>\n" + interval_note(data, columns);
}

}  // namespace tribotrack::apps
