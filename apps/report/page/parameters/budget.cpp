#include "apps/report/page/parameters/budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/text.h"

namespace tribotrack::apps {
namespace {

std::string source_sd(const ReportBudgetEntry& entry) {
  if (entry.quantity.empty() || !std::isfinite(entry.sd)) return "";
  const ParameterText shown = parameter_text(entry.quantity);
  return rounded(entry.sd, entry.sd) + (shown.unit.empty() ? "" : " " + shown.unit);
}

std::string bar_cell(double contribution, double sd) {
  const double share = sd > 0 && std::isfinite(sd) ? std::min(1.0, std::abs(contribution) / sd) : 0;
  return fmt::format("<td class=\"n bar\" style=\"--share:{:.1f}%\">{}</td>", 100 * share,
                     rounded(contribution, contribution));
}

std::string row(const ReportData& data, const ReportBudgetEntry& entry) {
  std::string html = fmt::format("<tr{}><th>{}</th>{}{}", entry.counted ? "" : " class=\"exact\"",
                                 escape_html(entry.source), number_cell(source_sd(entry)), cell(entry.from));
  for (std::size_t i = 0; i < data.parameters.size() && i < entry.contribution.size(); ++i)
    html += bar_cell(entry.contribution[i], entry.counted ? data.parameters[i].sd : 0);
  return html + "</tr>\n";
}

}  // namespace

std::string budget_table(const ReportData& data) {
  if (data.budget.empty()) return "";
  std::string html;
  if (!data.improve_first.empty()) html += "<p>" + sentence_html(data.improve_first) + "</p>\n";
  html +=
      "<div class=\"wide\"><table id=\"budget-table\" class=\"budget\"><thead><tr><th>Source</th><th "
      "class=\"n\">Its standard deviation</th><th>From</th>";
  for (const ReportParameter& p : data.parameters) {
    const ParameterText shown = parameter_text(p.name);
    html +=
        fmt::format("<th class=\"n\">{}{}</th>", shown.symbol, shown.unit.empty() ? "" : ", " + shown.unit);
  }
  html += "</tr></thead><tbody>\n";
  for (const ReportBudgetEntry& entry : data.budget)
    if (entry.counted) html += row(data, entry);
  html += "<tr><th>All together</th><td></td><td></td>";
  for (const ReportParameter& p : data.parameters) html += number_cell(rounded(p.sd, p.sd));
  html += "</tr>\n";
  bool exact = false;
  for (const ReportBudgetEntry& entry : data.budget) {
    if (entry.counted) continue;
    html += row(data, entry);
    exact = true;
  }
  html +=
      "</tbody></table></div>\n<p class=\"note\">What each source gives to the standard deviation of a "
      "parameter (JCGM 100); the squares add up. A bar is as long as its share of the whole.";
  if (exact)
    html +=
        " What was taken as exact is not counted: the rows in grey say what an error as large as stated "
        "would "
        "add; give its standard deviation (the key with <code>_sd</code>) to count it.";
  return html + "</p>\n";
}

}  // namespace tribotrack::apps
