#include "apps/report/tables/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/page/text.h"
#include "apps/text/csv_table.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

/// A row of runs.csv.
Json row_of(const ReportRun& run, std::size_t number) {
  using Residual = fit::Residual;
  Json row = {{"number", number},
              {"name", run.name},
              {"kind", run.free_slide ? "free_slide" : "displacement"},
              {"video", run.video},
              {"phi_rad", run.phi_rad},
              {"dtau_rad", run.dtau_rad}};
  const auto add_measured = [&](const std::string& key) {  // of measurements/NAME.json
    row[key] = run.value(key).value;
    row[key + "_sd"] = run.value(key).sd;
  };
  add_measured("alpha_rad");
  row["alpha_model_rad"] = run.modelled("alpha_rad");
  add_measured("v_mm_s");
  row["v_model_mm_s"] = run.modelled("v_mm_s");
  for (const std::string axis : {"dx", "dy"}) {
    const std::string key = axis + "_mm";
    row[key] = run.residual(key.c_str(), &Residual::measured);
    row[key + "_sd"] = run.residual(key.c_str(), &Residual::sd);
    row[axis + "_model_mm"] = run.modelled(key.c_str());
    row[axis + "_residual_sd"] = run.residual(key.c_str(), &Residual::standardised);
  }
  row["cycles"] = run.cycles > 0 ? run.cycles : no_value;
  for (const char* key : {"amplitude_mm", "angular_frequency_rad_s", "phase_shift_rad"}) add_measured(key);
  row["frames_ok"] = run.frames_ok();
  row["frames_lost"] = run.track.lost;
  row["frames_edge"] = run.track.edge;
  row["frames_repeated"] = run.track.repeats;
  row["frame_rate_hz"] = run.track.frame_rate_hz.value_or(no_value);
  row["sigma_px"] = run.sigma_px;
  row["failure"] = run.failure;
  return row;
}

}  // namespace

std::string runs_csv(const ReportData& data) {
  std::vector<Json> rows;
  for (const ReportRun& run : data.runs) rows.push_back(row_of(run, rows.size() + 1));
  return csv_of(rows);
}

std::string parameters_csv(const ReportData& data) {
  std::string csv =
      "parameter,estimate,sd,ci95_low,ci95_high,covariance_ci95_low,covariance_ci95_high,profile_ci95_low,"
      "profile_ci95_high";
  const auto& parameters = data.fit.parameters;
  for (const fit::ParameterEstimate& p : parameters)
    csv += fmt::format(",correlation_with_{}", fit::to_string(p.parameter));
  csv += "\n";
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const fit::ParameterEstimate& p = parameters[i];
    csv += fmt::format("{},{},{}", fit::to_string(p.parameter), exact(p.estimate), exact(p.sd));
    // An open end is no number: an empty cell.
    for (const fit::Interval& range : {p.ci95, p.covariance_ci95, p.profile_ci95})
      csv += fmt::format(",{},{}", exact(range.low), exact(range.high));
    for (const double r : data.fit.correlation.row(static_cast<Eigen::Index>(i))) csv += "," + exact(r);
    csv += "\n";
  }
  return csv;
}

namespace {

std::string values(const fit::FitResult& fit) {
  std::string text;
  for (const fit::ParameterEstimate& p : fit.parameters) {
    const std::string unit = parameter_text(p.parameter).unit;
    text += fmt::format("  {:<14} {:>20}{}   95 %: {}\n", fit::to_string(p.parameter),
                        quoted(p.estimate, p.sd), unit.empty() ? "" : " " + unit, quoted_interval(p));
  }
  for (std::size_t i = 0; i < fit.parameters.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      text += fmt::format("  correlation of {} and {}: {:.2f}\n", fit::to_string(fit.parameters[i].parameter),
                          fit::to_string(fit.parameters[k].parameter),
                          fit.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)));
  return text;
}

std::string goodness_text(const fit::FitResult& fit) {
  if (!std::isfinite(fit.chi2)) return "";
  std::string text = fmt::format("  chi2 = {:.4g} with {} degrees of freedom", fit.chi2, fit.dof);
  if (std::isfinite(fit.p_value) && fit.dof > 0)
    text += fit.p_value > 0 ? fmt::format(", p = {:.2g} (threshold 0.001)", fit.p_value)
                            : ", p < 1e-300 (threshold 0.001)";
  return text + "\n";
}

std::string budget(const fit::FitResult& fit) {
  std::string text;
  for (const fit::BudgetEntry& entry : fit.budget) {
    if (!entry.counted) continue;
    text += fmt::format("  {:<41}", entry.source);
    for (const double contribution : entry.contribution)
      text += fmt::format(" {:>14}", rounded_to_sd(contribution, std::abs(contribution)));
    text += "  " + entry.from + "\n";
  }
  if (text.empty()) return "";
  std::string head =
      fmt::format("uncertainty budget, contributions to the standard uncertainties\n  {:<41}", "source");
  for (const fit::ParameterEstimate& p : fit.parameters)
    head += fmt::format(" {:>14}", fit::to_string(p.parameter));
  return head + "\n" + text + "\n";
}

}  // namespace

std::string report_text(const ReportData& data) {
  std::string text = data.title + "\n" + subtitle_of(data) + "\n\n" + verdict_of(data).heading + ". " +
                     verdict_of(data).paragraph + "\n\n";
  if (data.fitted())
    text += "parameters: estimate(standard uncertainty in the last digits)\n" + values(data.fit) +
            goodness_text(data.fit) + "\n" + budget(data.fit);
  if (!data.warnings.empty()) {
    text += "warnings\n";
    for (const std::string& warning : data.warnings) text += "  - " + warning + "\n";
    text += "\n";
  }
  text += "methods\n  " + methods_text(data) + "\n\nto cite\n";
  for (const std::string& source : sources_to_cite(data)) text += "  " + source + "\n";
  return text;
}

namespace {

constexpr double fit_rejects =
    0.001;  // p of chi-square below which the data contradict the model (fit/fit_result.h)

/// "in 6.9 of 100 campaigns".
std::string how_often(double probability) {
  if (probability < 1e-3) return "in fewer than one of 1000 campaigns";
  if (probability > 0.1) return fmt::format("in {:.0f} of 100 campaigns", 100 * probability);
  return fmt::format("in {} of 100 campaigns", number(100 * probability, 2));
}

/// For a table. A probability that underflows is small, not zero.
std::string chance(double probability) {
  return probability == 0 ? "&lt; 1e-300" : number(probability, 1);
}

std::string goodness(const fit::FitResult& fit) {
  if (!std::isfinite(fit.chi2)) return "<p>χ² was not computed.</p>\n";
  std::string html = fmt::format("<p>χ² = {} with {} degree{} of freedom", number(fit.chi2), fit.dof,
                                 fit.dof == 1 ? "" : "s");
  if (fit.dof > 0) {
    html += fmt::format(
        ": {} per degree of freedom, where {} is expected (probability 0.99) if the model and the stated "
        "errors are right",
        number(fit.chi2 / fit.dof, 3), expected_chi2_text(fit.dof, fit.noise_dof));
  }
  html += fit.dof > 0 ? "." : ": as many data as unknowns, so that nothing checks the model.";
  if (fit.scatter > 0)
    html += fmt::format(" Scatter of up to {} mm per axis beyond the measurement errors is included.",
                        number(1e3 * fit.scatter, 2));
  html += "</p>\n";
  if (std::isfinite(fit.p_value) && fit.dof > 0)
    html += fmt::format(
        "<p><b>p {}</b>: {}chance alone would make χ² so large {}. The model would be rejected below p = {}; "
        "it is{}.</p>\n",
        fit.p_value > 0 ? "= " + number(fit.p_value, 2) : "&lt; 1e-300",
        fit.scatter > 0 ? "without the scatter estimated from the residuals, " : "", how_often(fit.p_value),
        number(fit_rejects, 1), fit.p_value < fit_rejects ? "" : " not");
  return html;
}

std::string phi_or_dash(double phi) {
  return std::isfinite(phi) ? angle(phi) : "–";
}

std::string outlier_table(const ReportData& data) {
  const std::vector<fit::Outlier>& outliers = data.fit.outliers;
  if (outliers.empty()) return "";
  const bool mislabelled = std::ranges::any_of(
      outliers, [](const fit::Outlier& outlier) { return outlier.looks_like_phi.has_value(); });
  std::vector<std::string> headings = {"Run", ">deviation", ">probability"};
  if (mislabelled) headings.insert(headings.end(), {">φ as given", ">φ that would fit"});
  std::string html;
  for (const fit::Outlier& outlier : outliers) {
    html += "<tr>" + cell("<b>" + escape_html(outlier.run) + "</b>") +
            number_cell(number(outlier.deviation, 2) + " σ") + number_cell(chance(outlier.chance));
    if (mislabelled) {
      const auto run = std::ranges::find(data.runs, outlier.run, &ReportRun::name);
      html += number_cell(run != data.runs.end() ? phi_or_dash(run->phi_rad) : "–") +
              number_cell(phi_or_dash(outlier.looks_like_phi.value_or(no_value)));
    }
    html += "</tr>";
  }
  return "<h3>Runs that contradict the others</h3>\n<p>Each is compared with the fit to all other runs; "
         "check its φ, Δτ and label, or leave it out.</p>\n" +
         table("outliers", "compact outliers", headings, html);
}

/// Runs that were kept out of the fit, predicted and measured.
std::string prediction_table(const ReportData& data) {
  std::string rows;
  for (const ReportRun& run : data.runs) {
    if (!run.fitted.prediction) continue;
    rows += "<tr>" + cell("<b>" + escape_html(run.name) + "</b>");
    for (const char* observable : {"alpha_rad", "v_mm_s"}) {
      const double sd = run.residual(observable, &fit::Residual::sd);
      rows += number_cell(quoted_value(run.residual(observable, &fit::Residual::measured), sd)) +
              number_cell(rounded(run.modelled(observable), sd));
    }
    rows += number_cell(chance(run.fitted.prediction->p_value)) + "</tr>";
  }
  if (rows.empty()) return "";
  return "<h3>Runs kept out of the fit</h3>\n<p>What the fit to the others predicts, against what was "
         "measured; in parentheses the standard uncertainty of both together.</p>\n" +
         table("predictions", "compact",
               {"Run", ">α, rad", ">predicted", ">v, mm/s", ">predicted", ">probability"}, rows);
}

/// "0.0995(10)" of a parameter under an explanation.
std::string cell_of(const std::map<fit::FitParameter, fit::EstimateUnder>& under,
                    fit::FitParameter parameter) {
  const auto found = under.find(parameter);
  return number_cell(found == under.end() ? "–" : quoted(found->second.estimate, found->second.sd));
}

/// What would explain the residuals, best first, with the values under it.
std::string explanation_table(const fit::FitResult& fit) {
  constexpr std::size_t kMostShown = 8;
  if (fit.explanations.empty()) return "";
  std::vector<std::string> headings = {"Set free", ">χ² falls by", ">p left", ">size"};
  for (const fit::ParameterEstimate& p : fit.parameters)
    headings.push_back(">" + parameter_text(p.parameter).symbol);
  headings.emplace_back();
  std::string html;
  const auto parameters = [&](const std::map<fit::FitParameter, fit::EstimateUnder>& under) {
    std::string cells;
    for (const fit::ParameterEstimate& p : fit.parameters) cells += cell_of(under, p.parameter);
    return cells;
  };
  if (!fit.as_assumed.empty())
    html += "<tr>" + cell("<b>nothing</b>") + number_cell("") + number_cell(chance(fit.p_value)) +
            number_cell("") + parameters(fit.as_assumed) + cell("as described") + "</tr>\n";
  for (std::size_t i = 0; i < std::min(fit.explanations.size(), kMostShown); ++i) {
    const fit::Explanation& e = fit.explanations[i];
    html += "<tr>" + cell(escape_html(e.run.empty() ? e.name : e.name + " " + e.run)) +
            number_cell(number(e.chi2_fall)) + number_cell(chance(e.p_after)) +
            number_cell(quoted(e.size, e.size_sd) + " " + escape_html(e.unit)) + parameters(e.parameters) +
            cell(e.explains   ? "<b>explains them</b>"
                 : e.refitted ? "fitted"
                              : "") +
            "</tr>\n";
  }
  return "<h3>What would explain the residuals</h3>\n<p>Each row sets free what the fit takes as exact, or "
         "knows to an uncertainty only: by how much χ² falls, the probability that is left, how large it "
         "would have to be, and the parameters under it. Rows that were not refitted are to first "
         "order.</p>\n" +
         table("explanations", "compact models", headings, html);
}

std::string not_needed(const fit::FitResult& fit) {
  if (fit.left_out.empty()) return "";
  return "<h3>Analyses that were not needed</h3>\n" + html_list(fit.left_out);
}

}  // namespace

PageSection check_section(const ReportData& data, const std::vector<Figure>& figures) {
  PageSection section{"check", "Does the model describe the data?", ""};
  if (!data.fitted()) return section;
  section.html = goodness(data.fit) + figure_box(figures, "residuals") + outlier_table(data) +
                 prediction_table(data) + explanation_table(data.fit) + not_needed(data.fit);
  return section;
}

namespace {

std::string source_sd(const fit::BudgetEntry& entry) {
  if (entry.quantity.empty() || !std::isfinite(entry.sd)) return "";
  const ParameterText shown = parameter_text(entry.quantity);
  return rounded(entry.sd, entry.sd) + (shown.unit.empty() ? "" : " " + shown.unit);
}

std::string bar_cell(double contribution, double sd) {
  const double share = sd > 0 && std::isfinite(sd) ? std::min(1.0, std::abs(contribution) / sd) : 0;
  return fmt::format("<td class=\"n bar\" style=\"--share:{:.1f}%\">{}</td>", 100 * share,
                     rounded(contribution, contribution));
}

std::string row(const fit::FitResult& fit, const fit::BudgetEntry& entry) {
  std::string html =
      fmt::format("<tr{}><th>{}</th>{}{}", entry.counted ? "" : " class=\"exact\"", escape_html(entry.source),
                  number_cell(source_sd(entry)), cell(escape_html(entry.from)));
  for (std::size_t i = 0; i < fit.parameters.size(); ++i)
    html +=
        bar_cell(entry.contribution(static_cast<Eigen::Index>(i)), entry.counted ? fit.parameters[i].sd : 0);
  return html + "</tr>\n";
}

}  // namespace

std::string budget_table(const fit::FitResult& fit) {
  if (fit.budget.empty()) return "";
  std::string html;
  if (!fit.improve_first.empty()) html += "<p>" + sentence_html(fit.improve_first) + "</p>\n";
  std::vector<std::string> headings = {"Source", ">Standard uncertainty u(x)", "Evaluated from"};
  for (const fit::ParameterEstimate& p : fit.parameters) {
    const ParameterText shown = parameter_text(p.parameter);
    headings.push_back(">u(" + shown.symbol + ")" + (shown.unit.empty() ? "" : ", " + shown.unit));
  }
  std::string rows;
  for (const fit::BudgetEntry& entry : fit.budget)
    if (entry.counted) rows += row(fit, entry);
  rows += "<tr><th>Combined</th><td></td><td></td>";
  for (const fit::ParameterEstimate& p : fit.parameters) rows += number_cell(rounded(p.sd, p.sd));
  rows += "</tr>\n";
  bool exact = false;
  for (const fit::BudgetEntry& entry : fit.budget) {
    if (entry.counted) continue;
    rows += row(fit, entry);
    exact = true;
  }
  html += table("budget-table", "budget", headings, rows) +
          "<p class=\"note\">Contribution of each source to the combined standard uncertainty of each "
          "parameter (JCGM 100): the squares add up. The length of a bar is its share.";
  if (exact)
    html +=
        " What was taken as exact is not included: the rows in grey say what an error as large as stated "
        "would add; give its standard uncertainty (the key with <code>_sd</code>) to include it.";
  return html + "</p>\n";
}

}  // namespace tribotrack::apps
