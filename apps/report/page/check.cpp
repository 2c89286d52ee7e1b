#include "apps/report/page/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/text.h"
#include "apps/report/findings/verdict.h"

namespace tribotrack::apps {
namespace {

constexpr double runs_test_rejects = 0.01;  // p below which neighbouring residuals are called correlated
constexpr long runs_test_needs = 8;         // runs, to be able to reject anything
constexpr double fit_rejects =
    0.001;  // p of chi-square below which the data contradict the model (fit/fit_result.h)

/// "in 6.9 of 100 campaigns".
std::string how_often(double probability) {
  return probability < 1e-3 ? "in fewer than one of 1000 campaigns"
                            : fmt::format("in {} of 100 campaigns", number(100 * probability, 2));
}

/// For a table. A probability that underflows is small, not zero.
std::string chance(double probability) {
  return probability == 0 ? "&lt; 1e-300" : number(probability, 1);
}

std::string goodness(const ReportData& data) {
  if (!std::isfinite(data.chi2)) return "<p>χ² was not computed.</p>\n";
  std::string html = fmt::format("<p>χ² = {} with {} degree{} of freedom", number(data.chi2), data.dof,
                                 data.dof == 1 ? "" : "s");
  if (data.dof > 0) {
    html += fmt::format(
        ": {} per degree of freedom, where {} is expected (probability 0.99) if the model and the stated "
        "errors are right",
        number(data.chi2 / data.dof, 3), expected_chi2_text(data.dof));
  }
  html += data.dof > 0 ? "." : ": as many data as unknowns, so that nothing checks the model.";
  if (data.scatter_mm > 0)
    html += fmt::format(" Scatter of up to {} mm per axis beyond the measurement errors is included.",
                        number(data.scatter_mm, 2));
  html += "</p>\n";
  if (std::isfinite(data.p_value) && data.dof > 0)
    html += fmt::format(
        "<p><b>p {}</b>: {}chance alone would make χ² so large {}. Below p = {} the data are taken to "
        "contradict the "
        "model{}.</p>\n",
        data.p_value > 0 ? "= " + number(data.p_value, 2) : "&lt; 1e-300",
        data.scatter_mm > 0 ? "without the scatter estimated from the residuals, " : "",
        how_often(data.p_value), number(fit_rejects, 1),
        data.p_value < fit_rejects ? ": they do" : ": they do not");
  return html;
}

long used_runs(const ReportData& data) {
  return std::ranges::count_if(
      data.runs, [](const ReportRun& run) { return run.failure.empty() && !run.residuals.empty(); });
}

std::string runs_test(const ReportData& data) {
  const double p = data.runs_test_p_value;
  if (!std::isfinite(p)) return "";
  const char* result =
      p < runs_test_rejects
          ? "residuals of neighbouring runs have the same sign more often than by chance, which points to "
            "a wrong model rather than to scatter."
      : p < 1 ? "no sign that residuals of neighbouring runs go together, as they would under a wrong model."
      : used_runs(data) < runs_test_needs ? "with fewer than eight runs the test decides nothing."
                                          : "residuals of neighbouring runs change sign as often as by "
                                            "chance or more often: no sign of a wrong model.";
  return fmt::format("<p><b>Runs test: p = {}</b> (threshold {}): {}</p>\n", number(p, 2),
                     number(runs_test_rejects, 1), result);
}

std::string phi_or_dash(double phi) {
  return std::isfinite(phi) ? angle(phi) : "–";
}

std::string outlier_table(const ReportData& data) {
  if (data.outliers.empty()) return "";
  const bool mislabelled = std::any_of(data.outliers.begin(), data.outliers.end(), [](const auto& outlier) {
    return std::isfinite(outlier.looks_like_phi_rad);
  });
  std::string html =
      "<h3>Runs that contradict the others</h3>\n<p>Each is compared with the fit to all other runs; check "
      "its φ, Δτ and label, or leave it out.</p>\n<div class=\"wide\"><table id=\"outliers\" class=\"compact "
      "outliers\"><thead><tr><th>Run</th><th class=\"n\">deviation</th><th class=\"n\">probability</th>";
  if (mislabelled) html += "<th class=\"n\">φ as given</th><th class=\"n\">φ that would fit</th>";
  html += "</tr></thead><tbody>";
  for (const ReportOutlier& outlier : data.outliers) {
    html += "<tr>" + cell("<b>" + escape_html(outlier.run) + "</b>") +
            number_cell(number(outlier.deviation, 2) + " σ") + number_cell(chance(outlier.chance));
    if (mislabelled) {
      const auto run = std::find_if(data.runs.begin(), data.runs.end(),
                                    [&](const ReportRun& r) { return r.name == outlier.run; });
      html += number_cell(run != data.runs.end() ? phi_or_dash(run->phi_rad) : "–") +
              number_cell(phi_or_dash(outlier.looks_like_phi_rad));
    }
    html += "</tr>";
  }
  return html + "</tbody></table></div>\n";
}

std::string outlying_points(const ReportData& data) {
  std::string items;
  for (const ReportRun& run : data.runs)
    if (run.outlying_points > 0)
      items += fmt::format("<li><b>{}</b>: {} of {} points.</li>", escape_html(run.name), run.outlying_points,
                           run.points);
  if (items.empty()) return "";
  return "<h3>Points that contradict their run</h3>\n<p>They lie beyond 6 σ of the run’s other points; the "
         "warnings name their frames.</p>\n<ul>" +
         items + "</ul>\n";
}

std::string model_table(const ReportData& data) {
  if (data.models.empty()) return "";
  const ReportModel& fitted = data.models.front();
  std::string html =
      "<h3>Other models, fitted to the same runs</h3>\n<p>AIC and BIC weigh the misfit against the number of "
      "unknowns: lower is better; Δ is the difference from the first model, and less than 6 in AIC is not "
      "taken as evidence.</p>\n<div "
      "class=\"wide\"><table id=\"models\" class=\"compact models\"><thead><tr><th>Model</th><th "
      "class=\"n\">unknowns</th><th class=\"n\">χ²</th><th class=\"n\">AIC</th><th class=\"n\">ΔAIC</th><th "
      "class=\"n\">BIC</th><th class=\"n\">ΔBIC</th><th>Result</th></tr></thead><tbody>\n";
  const auto signed_difference = [](double value, double first) {
    const double difference = value - first;
    return std::isfinite(difference) ? (difference > 0 ? "+" : "") + rounded(difference, 1) : "–";
  };
  for (const ReportModel& model : data.models) {
    const bool first = &model == &fitted;
    const std::string name = escape_html(model.name);
    html +=
        "<tr>" + cell(first ? "<b>" + name + "</b> (fitted)" : name) +
        number_cell(std::to_string(model.unknowns)) + number_cell(number(model.chi2)) +
        number_cell(number(model.aic)) + number_cell(first ? "" : signed_difference(model.aic, fitted.aic)) +
        number_cell(number(model.bic)) + number_cell(first ? "" : signed_difference(model.bic, fitted.bic)) +
        cell(sentence_html(model.finding)) + "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string not_needed(const ReportData& data) {
  if (data.left_out.empty()) return "";
  return "<h3>Analyses that were not needed</h3>\n" + html_list(data.left_out);
}

}  // namespace

PageSection check_section(const ReportData& data, const std::vector<Figure>& figures) {
  PageSection section{"check", "Does the model describe the data?", ""};
  if (!data.fitted || data.parameters.empty()) return section;
  section.html = goodness(data) + runs_test(data) + figure_box(figures, "residuals") + outlier_table(data) +
                 outlying_points(data) + model_table(data) + not_needed(data);
  return section;
}

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
