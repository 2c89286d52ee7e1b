// The report: its page, with the sections that are text and tables, and the files beside it.
#include "apps/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "apps/page/page.h"
#include "apps/page/text.h"
#include "apps/report/data/data.h"
#include "apps/report/page/page.h"
#include "apps/report/tables/tables.h"

namespace tribotrack::apps {
namespace {

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
  if (rows.empty()) return "";
  return "<h3>Conditions: given, measured, used</h3>\n" +
         table("conditions", "compact conditions",
               {"Quantity", ">given", ">measured, all runs pooled", ">difference", ">used", "from"}, rows);
}

/// Blue below, orange above: distinct to colour-blind eyes, and the number stands in the cell.
std::string correlation_colour(double r) {
  const double strength = std::min(std::abs(r), 1.0);
  const char* rgb = r < 0 ? "0,114,178" : "213,94,0";
  return fmt::format("background:rgba({},{:.2f})", rgb, 0.55 * strength);
}

std::string correlation_table(const ReportData& data) {
  const auto& parameters = data.fit.parameters;
  const auto n = static_cast<Eigen::Index>(parameters.size());
  if (n < 2 || data.fit.correlation.rows() != n) return "";
  std::vector<std::string> headings = {""};
  for (const fit::ParameterEstimate& p : parameters)
    headings.push_back(">" + parameter_text(p.parameter).symbol);
  std::string html;
  for (Eigen::Index i = 0; i < n; ++i) {
    html += "<tr><th>" + parameter_text(parameters[static_cast<std::size_t>(i)].parameter).symbol + "</th>";
    for (Eigen::Index k = 0; k < n; ++k) {
      const double r = data.fit.correlation(i, k);
      html += i == k ? "<td class=\"n\">1</td>"
                     : fmt::format("<td class=\"n\" style=\"{}\">{}</td>", correlation_colour(r),
                                   std::isnan(r) ? "–" : rounded(r, 0.1));
    }
    html += "</tr>";
  }
  return "<h3>Correlation of the parameters</h3>\n" +
         table("correlation", "compact correlation", headings, html) +
         "<p class=\"note\">Near +1 or −1, an error in one parameter is compensated by the other: only their "
         "combination is known well.</p>\n";
}

std::string identifiability_text(const ReportData& data) {
  constexpr const char* kAnswers[] = {
      // in the order of fit::Verdict
      "Yes: every parameter is determined by these runs.",
      "Only weakly: these runs depend little on some combination of the parameters.",
      "<b>No</b>: these runs leave some combination of the parameters undetermined."};
  const fit::Identifiability& judged = data.fit.identifiability;
  std::string html = fmt::format("<h3>Do the data determine each parameter?</h3>\n<p>{}</p>\n",
                                 kAnswers[static_cast<int>(judged.verdict)]);
  if (!judged.weak_directions.empty()) html += html_list(judged.weak_directions);
  constexpr std::size_t kMostMinima = 3;
  std::vector<std::string> other_minima;
  for (std::size_t k = 1; data.fit.dof > 0 && k < std::min(data.fit.minima.size(), 1 + kMostMinima); ++k)
    other_minima.push_back(data.fit.minima[k].sentence);
  if (!other_minima.empty())
    html +=
        "<h3>Other minima</h3>\n<p>Other values fit nearly as well; the intervals to quote include them "
        "where they are within 95 %.</p>\n" +
        html_list(other_minima);
  return html;
}

std::string shared_scale(const ReportData& data) {
  if (data.shared_scale.empty()) return "";
  return "<h3>Scale of the recordings</h3>\n<p>" + sentence_html(data.shared_scale) + ".</p>\n";
}

std::string verdict_box(const ReportData& data) {
  const Verdict verdict = verdict_of(data);
  return fmt::format("<div id=\"verdict\" class=\"verdict {}\"><h2>{}</h2>\n<p>{}</p></div>\n", verdict.style,
                     sentence_html(verdict.heading), sentence_html(verdict.paragraph));
}

std::string warning_box(const ReportData& data) {
  if (data.warnings.empty()) return "";
  return fmt::format("<div id=\"warnings\" class=\"warnings\"><h2>{}</h2>\n{}</div>\n",
                     data.warnings.size() == 1 ? "Warning" : fmt::format("{} warnings", data.warnings.size()),
                     html_list(data.warnings));
}

}  // namespace

PageSection parameter_section(const ReportData& data, const std::vector<Figure>& figures) {
  PageSection section{"parameters", "Parameters", ""};
  if (!data.fitted()) return section;
  section.html = interval_table(data) + "<div class=\"columns\">\n<div>" + identifiability_text(data) +
                 shared_scale(data) + "</div>\n<div>" + correlation_table(data) + "</div>\n</div>\n" +
                 figure_box(figures, "corner") + figure_box(figures, "friction") + condition_table(data);
  return section;
}

PageSection budget_section(const ReportData& data, const std::vector<Figure>& figures) {
  PageSection section{"budget", "Where the uncertainty comes from", ""};
  if (!data.fitted()) return section;
  section.html = budget_table(data.fit) + figure_box(figures, "influence");
  return section;
}

PageSection provenance_section(const ReportData& data) {
  PageSection section{"provenance", "Provenance", "", true};
  std::string& html = section.html;
  html += "<p>Made by tribotrack " +
          escape_html(data.program_version.empty() ? "(version not stated)" : data.program_version) +
          ". Figures drawn with plotly.js (MIT licence), which is part of this page; the page fetches "
          "nothing.</p>\n";
  if (!data.inputs.empty()) {
    std::string rows;
    for (const Input& input : data.inputs)
      rows += "<tr>" + cell(escape_html(input.path.filename().string())) +
              cell("<code>xxh3-128:" + escape_html(input.xxh3_128) + "</code>" +
                   (input.hashed.empty() ? "" : ", " + escape_html(input.hashed))) +
              "</tr>";
    html += "<details class=\"print\"><summary>Inputs and their hashes</summary>\n" +
            table("inputs", "compact", {"File", "Hash"}, rows) + "</details>\n";
  }
  if (!data.configuration.empty())
    html += "<details class=\"screen-only\"><summary>Effective configuration</summary>\n<pre>" +
            escape_html(data.configuration) + "</pre></details>\n";
  return section;
}

namespace {

std::string result_table(const ReportData& data) {
  if (!data.fitted()) return "";
  const auto& described = data.fit.as_assumed;
  std::string html = fmt::format(
      "<table id=\"result\" class=\"result\"><thead><tr><th>Parameter</th><th>Estimate, 95 % "
      "interval</th>{}</tr></thead><tbody>\n",
      described.empty() ? "" : "<th>as described, rejected</th>");
  for (const fit::ParameterEstimate& p : data.fit.parameters) {
    const ParameterText shown = parameter_text(p.parameter);
    const bool determined = std::isfinite(p.estimate) && std::isfinite(p.sd);
    html += fmt::format(
        "<tr><th>{}</th><td class=\"value\" data-v=\"{}\">{}{}<br><span class=\"ends\">{}</span></td>",
        shown.symbol, determined ? fmt::format("{}", p.estimate) : "", quoted_value(p.estimate, p.sd),
        shown.unit.empty() || !determined ? "" : " " + shown.unit, determined ? quoted_interval(p) : "");
    if (const auto as = described.find(p.parameter); as != described.end())
      html += "<td>" + quoted_value(as->second.estimate, as->second.sd) + "<br><span class=\"ends\">" +
              interval_text(as->second.ci95.low, as->second.ci95.high, as->second.sd) + "</span></td>";
    html += "</tr>\n";
  }
  return html +
         "</tbody></table>\n<p class=\"note\">In parentheses the standard uncertainty, in the last "
         "digits.</p>\n";
}

/// What the values assume, and what to do next.
std::string basis(const ReportData& data) {
  if (!data.fitted()) return "";
  std::string html = "<div class=\"basis\"><h2>It assumes</h2>\n" + html_list(assumptions(data));
  std::vector<std::string> steps;
  if (data.fit.verdict != fit::Use::do_not_use && !data.fit.improve_first.empty())
    steps.push_back(data.fit.improve_first);
  if (const auto next = data.next_runs(); !next.empty()) steps.push_back(next.front().sentence);
  std::string list;
  if (data.fit.verdict == fit::Use::do_not_use)
    list = "<li>Find out what is wrong: <a href=\"#check\">does the model describe the data?</a></li>";
  for (const std::string& step : steps) list += "<li>" + sentence_html(step) + "</li>";
  return html + (list.empty() ? "" : "<h2>Next</h2>\n<ul>" + list + "</ul>\n") + "</div>\n";
}

/// Of the figures the one shown there; empty where there is none.
std::string first_figure(const std::vector<Figure>& figures) {
  for (const char* id : {"alpha-phi", "alpha-dtau", "trajectories", "slide-1"})
    if (std::ranges::find(figures, std::string(id), &Figure::id) != figures.end()) return id;
  return "";
}

PageSection citing_section(const ReportData& data) {
  std::string html = "<p>" + sentence_html(methods_text(data)) + "</p>\n<h3>To cite</h3>\n<ul>";
  for (const std::string& source : sources_to_cite(data)) html += "<li>" + escape_html(source) + "</li>";
  return {"citing", "Methods and how to cite", html + "</ul>\n", true};
}

}  // namespace

std::string first_screen(const ReportData& data, const std::vector<Figure>& figures) {
  const std::string figure = figure_box(figures, first_figure(figures)), picture = first_picture(data);
  std::string html = verdict_box(data) + "<div class=\"first\">\n<div class=\"values\">" +
                     result_table(data) + "</div>\n" + basis(data);
  if (!picture.empty()) html += "<div class=\"picture\">" + picture + "</div>\n";
  if (!figure.empty()) html += "<div class=\"seen\">" + figure + "</div>\n";
  return html + "</div>\n" + warning_box(data);
}

std::string page_of(const ReportData& data, std::vector<Figure> of_campaign) {
  Page page{.name = data.title, .title = data.title, .subtitle = subtitle_of(data)};
  page.figures = std::move(of_campaign);
  std::vector<std::vector<Figure>> of_runs;
  for (std::size_t i = 0; i < data.runs.size(); ++i) of_runs.push_back(run_figures(data, i));

  const std::vector<Figure>& figures = page.figures;
  page.first = first_screen(data, figures);
  const std::string shown = first_figure(figures);
  for (PageSection section :
       {dependence_section(data, figures, shown), parameter_section(data, figures),
        check_section(data, figures), budget_section(data, figures), next_section(data),
        slide_section(data, figures, shown), run_section(data), citing_section(data), picture_section(data),
        detail_section(data, of_runs), audit_section(data), plan_section(data), provenance_section(data)})
    if (!section.html.empty()) page.sections.push_back(std::move(section));
  for (std::vector<Figure>& more : of_runs) std::ranges::move(more, std::back_inserter(page.figures));
  return html_of(std::move(page));
}

Report report_of(const RunFolder& folder) {
  const ReportData data = collect(folder);
  std::vector<Figure> figures = campaign_figures(data);
  Report report{"", runs_csv(data), parameters_csv(data), report_text(data), {}, data.missing};
  for (const Figure& figure : figures) report.figures.push_back(figure.id);
  report.page = page_of(data, std::move(figures));
  return report;
}

}  // namespace tribotrack::apps
