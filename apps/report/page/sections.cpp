#include "apps/report/page/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/report/page/budget.h"
#include "apps/report/page/intervals.h"
#include "apps/report/page/verdict.h"
#include "apps/report/text/text.h"

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

std::string given_table(const ReportData& data) {
  if (data.given.empty()) return "";
  std::string html =
      "<h3>Taken as known</h3>\n<div class=\"wide\" tabindex=\"0\"><table class=\"compact\"><tbody>";
  for (const ReportGiven& given : data.given) {
    const ParameterText shown = parameter_text(given.name);
    const bool in_radians = shown.unit == "rad";
    html += fmt::format("<tr><th>{}</th>", shown.symbol);
    html += number_cell(in_radians ? angle(given.value) : number(given.value, 6));
    html += cell(in_radians ? "" : shown.unit) + cell(escape_html(given.source)) + "</tr>";
  }
  return html + "</tbody></table></div>\n";
}

/// A value in the unit of its key; multiples of pi as such where no sd says more.
std::string quantity_cell(double value, double sd, const std::string& unit) {
  if (std::isnan(value)) return number_cell("–");
  if (unit == "rad" && std::isnan(sd)) return number_cell(angle(value));
  return number_cell((std::isnan(sd) ? number(value, 6) : value_and_sd(value, sd)) + " " + unit);
}

std::string condition_table(const ReportData& data) {
  if (data.conditions.empty()) return "";
  std::string html =
      "<h3>Conditions that the runs share: given and measured</h3>\n<div class=\"wide\" "
      "tabindex=\"0\"><table class=\"compact conditions\"><thead><tr><th></th><th class=\"n\">given</th><th "
      "class=\"n\">measured</th><th class=\"n\">difference</th><th class=\"n\">used</th><th>from</th></tr>"
      "</thead><tbody>";
  for (const ReportCondition& c : data.conditions) {
    const ParameterText shown = parameter_text(c.quantity);
    html += fmt::format("<tr><th>{}</th>", shown.symbol);
    html += quantity_cell(c.given, c.given_sd, shown.unit) + quantity_cell(c.measured, c.sd, shown.unit);
    html += number_cell(std::isnan(c.difference_in_sd) ? "–" : number(c.difference_in_sd, 2) + " σ");
    html += quantity_cell(c.used, c.used_sd, shown.unit) + cell(escape_html(c.from)) + "</tr>";
  }
  return html + "</tbody></table></div>\n";
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
      "<h3>Correlation of the parameters</h3>\n<div class=\"wide\" tabindex=\"0\"><table class=\"compact "
      "correlation\"><thead><tr><th></th>";
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

std::string verdict_section(const ReportData& data) {
  const Verdict verdict = verdict_of(data);
  std::string html =
      fmt::format("<section id=\"verdict\" class=\"verdict {}\"><h2>{}</h2>\n<p>{}</p></section>\n",
                  css_class(verdict.trust), verdict.heading, verdict.paragraph);
  if (!data.warnings.empty())
    html +=
        fmt::format("<section id=\"warnings\" class=\"warnings\"><h2>{}</h2>\n{}</section>\n",
                    data.warnings.size() == 1 ? "Warning" : fmt::format("{} warnings", data.warnings.size()),
                    html_list(data.warnings));
  return html;
}

std::string parameter_section(const ReportData& data) {
  if (!data.fitted || data.parameters.empty()) return "";
  std::string html = "<section id=\"parameters\"><h2>Parameters</h2>\n" + interval_table(data);
  html += "<div class=\"columns\">\n<div>" + identifiability_text(data) + systematics(data) +
          shared_scale(data) + "</div>\n<div>" + correlation_table(data) + given_table(data) +
          "</div>\n</div>\n" + budget_table(data) + condition_table(data);
  return html + "</section>\n";
}

std::string provenance_section(const ReportData& data) {
  std::string html = "<section id=\"provenance\"><h2>Provenance</h2>\n";
  html += "<p>Made by tribotrack " +
          escape_html(data.program_version.empty() ? "(version not stated)" : data.program_version) +
          " after S. Kilikevičius, K. Liutkauskienė and A. Fedaravičius, <i>Nonprehensile Manipulation of "
          "Parts on a Horizontal Circularly Oscillating Platform with Dynamic Dry Friction Control</i>, "
          "2021 (“the paper”). Figures drawn with plotly.js (MIT licence), which is part of this page; "
          "the page fetches nothing.</p>\n";
  if (!data.inputs.empty()) {
    html += "<details><summary>Inputs and their hashes</summary>\n<table class=\"compact\"><tbody>";
    for (const ReportSource& input : data.inputs)
      html += "<tr>" + cell(escape_html(input.name)) + cell("<code>" + escape_html(input.hash) + "</code>") +
              "</tr>";
    html += "</tbody></table></details>\n";
  }
  if (!data.configuration.empty())
    html += "<details><summary>Effective configuration</summary>\n<pre>" + escape_html(data.configuration) +
            "</pre></details>\n";
  return html + "</section>\n";
}

}  // namespace tribotrack::apps
