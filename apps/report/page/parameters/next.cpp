#include "apps/report/page/parameters/next.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/text.h"

namespace tribotrack::apps {
namespace {

/// Runs that are the same but for their aim stand in one row.
struct Row {
  ReportNextRun run;
  std::string aims;  ///< HTML
};

bool same(const ReportNextRun& a, const ReportNextRun& b) {
  const auto alike = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return alike(a.phi_rad, b.phi_rad) && alike(a.dtau_rad, b.dtau_rad) &&
         alike(a.amplitude_mm, b.amplitude_mm) && alike(a.w_rad_s, b.w_rad_s);
}

std::vector<Row> rows_of(const std::vector<ReportNextRun>& runs) {
  std::vector<Row> rows;
  for (const ReportNextRun& run : runs) {
    const std::string aim = run.aim.empty() ? "all together" : parameter_text(run.aim).symbol + " alone";
    const auto known = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return same(r.run, run); });
    if (known == rows.end())
      rows.push_back({run, aim});
    else
      known->aims += ", " + aim;
  }
  return rows;
}

/// Rounded to its own width: a quarter of it is about one sd.
std::string interval(const ReportInterval& range) {
  return interval_text(range.low, range.high, (range.high - range.low) / 4);
}

std::string next_table(const ReportData& data) {
  std::string html =
      "<div class=\"wide\"><table id=\"next-runs\" class=\"next\"><thead><tr><th>Best for</th><th "
      "class=\"n\">φ</th><th "
      "class=\"n\">Δτ</th><th class=\"n\">A, mm</th><th class=\"n\">ω, rad/s</th>";
  for (const ReportParameter& parameter : data.parameters) {
    const ParameterText shown = parameter_text(parameter.name);
    html += fmt::format("<th class=\"n\">{}{}</th>", shown.symbol,
                        shown.unit.empty() ? "" : fmt::format(", {}", shown.unit));
  }
  html += "</tr></thead><tbody>\n<tr><td>the runs so far</td><td></td><td></td><td></td><td></td>";
  for (const ReportParameter& parameter : data.parameters) html += number_cell(interval(parameter.ci95));
  html += "</tr>\n";
  for (const Row& row : rows_of(data.next_runs)) {
    html += "<tr>" + cell("<b>" + row.aims + "</b>") + number_cell(angle(row.run.phi_rad)) +
            number_cell(angle(row.run.dtau_rad)) + number_cell(number(row.run.amplitude_mm)) +
            number_cell(number(row.run.w_rad_s));
    for (std::size_t i = 0; i < data.parameters.size(); ++i)
      html += number_cell(i < row.run.predicted_ci95.size() ? interval(row.run.predicted_ci95[i]) : "–");
    html += "</tr>\n";
  }
  html +=
      "</tbody></table></div>\n<p class=\"note\">95 % intervals now, and as predicted with one more run, "
      "measured as well as those so far. A run at another A or ω helps only if the platform can be driven "
      "so.";
  if (data.identifiability == ReportVerdict::not_identifiable)
    html +=
        " The prediction assumes the values above, which these runs do not determine: the widths of the "
        "intervals are meaningful, their places are not.";
  return html + "</p>\n";
}

}  // namespace

PageSection next_section(const ReportData& data) {
  PageSection section{"next", "What to film next", ""};
  if (!data.fitted || data.parameters.empty()) return section;
  if (data.next_experiment.empty() && data.next_runs.empty()) return section;
  const std::string sentence =
      data.next_experiment.empty() ? data.next_runs.front().sentence : data.next_experiment;
  section.html = "<p>" + sentence_html(sentence) + "</p>\n";
  if (!data.next_runs.empty()) section.html += next_table(data);
  return section;
}

}  // namespace tribotrack::apps
