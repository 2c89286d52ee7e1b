#include "apps/report/page/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/text.h"
#include "apps/report/findings/verdict.h"
#include "apps/report/page/methods.h"
#include "apps/report/page/parameters/budget.h"
#include "apps/report/page/parameters/intervals.h"

namespace tribotrack::apps {
namespace {

const char* css_class(Trust trust) {
  switch (trust) {
    case Trust::usable:
      return "good";
    case Trust::with_care:
      return "care";
    case Trust::do_not_use:
      return "bad";
    case Trust::no_fit:
      return "none";
  }
  return "none";
}

/// A value in the unit of its key; multiples of pi as such where no sd says more.
std::string quantity_cell(double value, double sd, const std::string& unit) {
  if (std::isnan(value)) return number_cell("–");
  if (unit == "rad" && std::isnan(sd)) return number_cell(angle(value));
  return number_cell((std::isnan(sd) || sd == 0 ? number(value, 6) : quoted_value(value, sd)) +
                     (unit.empty() ? "" : " " + unit));
}

std::string condition_row(const ReportCondition& c) {
  const ParameterText shown = parameter_text(c.quantity);
  return fmt::format("<tr><th>{}</th>", shown.symbol) + quantity_cell(c.given, c.given_sd, shown.unit) +
         quantity_cell(c.measured, c.sd, shown.unit) +
         number_cell(std::isnan(c.difference_in_sd) ? "–" : number(c.difference_in_sd, 2) + " σ") +
         quantity_cell(c.used, c.used_sd, shown.unit) + cell(escape_html(c.from)) + "</tr>\n";
}

/// Every quantity that was not fitted, in one row each: given, measured, and which was used.
std::string condition_table(const ReportData& data) {
  std::string rows;
  for (const ReportCondition& c : data.conditions) rows += condition_row(c);
  for (const ReportGiven& given : data.given) {
    const bool pooled =
        std::ranges::any_of(data.conditions, [&](const auto& c) { return c.quantity == given.name; });
    if (pooled) continue;
    rows += condition_row(
        {.quantity = given.name, .given = given.value, .used = given.value, .from = given.source});
  }
  if (rows.empty()) return "";
  return "<h3>Conditions: given, measured, used</h3>\n<div class=\"wide\"><table id=\"conditions\" "
         "class=\"compact "
         "conditions\"><thead><tr><th>Quantity</th><th class=\"n\">given</th><th class=\"n\">measured, all "
         "runs "
         "pooled</th><th class=\"n\">difference</th><th "
         "class=\"n\">used</th><th>from</th></tr></thead><tbody>\n" +
         rows + "</tbody></table></div>\n";
}

/// Blue below, orange above: distinct to colour-blind eyes, and the number stands in the cell.
std::string correlation_colour(double r) {
  const double strength = std::min(std::abs(r), 1.0);
  const char* rgb = r < 0 ? "0,114,178" : "213,94,0";
  return fmt::format("background:rgba({},{:.2f})", rgb, 0.55 * strength);
}

std::string correlation_table(const ReportData& data) {
  const std::size_t n = data.parameters.size();
  if (n < 2 || data.correlation.size() != n) return "";
  std::string html =
      "<h3>Correlation of the parameters</h3>\n<div class=\"wide\"><table id=\"correlation\" "
      "class=\"compact correlation\"><thead><tr><td></td>";
  for (const ReportParameter& p : data.parameters)
    html += "<th class=\"n\">" + parameter_text(p.name).symbol + "</th>";
  html += "</tr></thead><tbody>";
  for (std::size_t i = 0; i < n; ++i) {
    html += "<tr><th>" + parameter_text(data.parameters[i].name).symbol + "</th>";
    for (std::size_t k = 0; k < n && k < data.correlation[i].size(); ++k) {
      const double r = data.correlation[i][k];
      html += i == k ? "<td class=\"n\">1</td>"
                     : fmt::format("<td class=\"n\" style=\"{}\">{}</td>", correlation_colour(r),
                                   std::isnan(r) ? "–" : rounded(r, 0.1));
    }
    html += "</tr>";
  }
  return html +
         "</tbody></table></div>\n<p class=\"note\">Near +1 or −1, an error in one parameter is compensated "
         "by "
         "the other: only their combination is known well.</p>\n";
}

std::string identifiability_text(const ReportData& data) {
  std::string html = "<h3>Do the data determine each parameter?</h3>\n<p>";
  switch (data.identifiability) {
    case ReportVerdict::identifiable:
      html += "Yes: every parameter is determined by these runs.";
      break;
    case ReportVerdict::weak:
      html += "Only weakly: these runs depend little on some combination of the parameters.";
      break;
    case ReportVerdict::not_identifiable:
      html += "<b>No</b>: these runs leave some combination of the parameters undetermined.";
      break;
  }
  html += "</p>\n";
  if (!data.weak_directions.empty()) html += html_list(data.weak_directions);
  const std::string remedy = !data.next_experiment.empty() ? data.next_experiment
                             : !data.next_runs.empty()     ? data.next_runs.front().sentence
                                                           : std::string();
  if (data.identifiability != ReportVerdict::identifiable && !remedy.empty())
    html += "<p><b>Remedy:</b> " + sentence_html(remedy) + "</p>\n";
  if (!data.other_minima.empty())
    html +=
        "<h3>Other minima</h3>\n<p>Other values fit nearly as well; the intervals to quote hold "
        "them where they are within 95 %.</p>\n" +
        html_list(data.other_minima);
  return html;
}

/// Of files without a budget.
std::string systematics(const ReportData& data) {
  if (data.systematics.empty() || !data.budget.empty()) return "";
  return "<h3>If a value taken as known is wrong</h3>\n<p>The parameters change by this much, which "
         "χ² may not show and which the intervals above do not include.</p>\n" +
         html_list(data.systematics);
}

std::string shared_scale(const ReportData& data) {
  if (data.shared_scale.empty()) return "";
  return "<h3>Scale of the recordings</h3>\n<p>" + sentence_html(data.shared_scale) + ".</p>\n";
}

}  // namespace

std::string verdict_box(const ReportData& data) {
  const Verdict verdict = verdict_of(data);
  return fmt::format("<div id=\"verdict\" class=\"verdict {}\"><h2>{}</h2>\n<p>{}</p></div>\n",
                     css_class(verdict.trust), verdict.heading, verdict.paragraph);
}

std::string warning_box(const ReportData& data) {
  if (data.warnings.empty()) return "";
  return fmt::format("<div id=\"warnings\" class=\"warnings\"><h2>{}</h2>\n{}</div>\n",
                     data.warnings.size() == 1 ? "Warning" : fmt::format("{} warnings", data.warnings.size()),
                     html_list(data.warnings));
}

PageSection parameter_section(const ReportData& data, const std::vector<Figure>& figures) {
  PageSection section{"parameters", "Parameters", ""};
  if (!data.fitted || data.parameters.empty()) return section;
  section.html = interval_table(data) + "<div class=\"columns\">\n<div>" + identifiability_text(data) +
                 systematics(data) + shared_scale(data) + "</div>\n<div>" + correlation_table(data) +
                 "</div>\n</div>\n" + figure_box(figures, "corner") + condition_table(data);
  return section;
}

PageSection budget_section(const ReportData& data, const std::vector<Figure>& figures) {
  PageSection section{"budget", "Where the uncertainty comes from", ""};
  if (!data.fitted || data.parameters.empty()) return section;
  section.html = budget_table(data) + figure_box(figures, "budget-shares") + figure_box(figures, "influence");
  return section;
}

PageSection citing_section(const ReportData& data) {
  return {"citing", "Methods and how to cite", methods_html(data), true};
}

PageSection provenance_section(const ReportData& data) {
  PageSection section{"provenance", "Provenance", "", true};
  std::string& html = section.html;
  html += "<p>Made by tribotrack " +
          escape_html(data.program_version.empty() ? "(version not stated)" : data.program_version) +
          ". Figures drawn with plotly.js (MIT licence), which is part of this page; the page fetches "
          "nothing.</p>\n";
  if (!data.inputs.empty()) {
    html +=
        "<details class=\"print\"><summary>Inputs and their hashes</summary>\n<table id=\"inputs\" "
        "class=\"compact\"><thead><tr><th>File</th><th>Hash</th></tr></thead><tbody>";
    for (const ReportSource& input : data.inputs)
      html += "<tr>" + cell(escape_html(input.name)) + cell("<code>" + escape_html(input.hash) + "</code>") +
              "</tr>";
    html += "</tbody></table></details>\n";
  }
  if (!data.configuration.empty())
    html += "<details class=\"screen-only\"><summary>Effective configuration</summary>\n<pre>" +
            escape_html(data.configuration) + "</pre></details>\n";
  return section;
}

}  // namespace tribotrack::apps
