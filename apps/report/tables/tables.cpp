#include "apps/report/tables/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "apps/page/text.h"
#include "apps/report/findings/verdict.h"
#include "apps/text/csv_table.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

double residual_of(const ReportRun& run, const char* observable, double ReportResidual::*number) {
  const auto found = std::ranges::find(run.residuals, observable, &ReportResidual::observable);
  return found == run.residuals.end() ? no_value : (*found).*number;
}

/// One column of runs.csv: its name and a run's cell.
struct Column {
  const char* name;
  std::function<std::string(const ReportRun&)> cell;
};

Column numbers(const char* name, double ReportRun::*member) {
  return {name, [member](const ReportRun& run) { return exact(run.*member); }};
}

Column of_platform(const char* name, double ReportPlatform::*member) {
  return {name, [member](const ReportRun& run) { return exact(run.platform.*member); }};
}

Column of_residual(const char* name, const char* observable, double ReportResidual::*member) {
  return {name, [=](const ReportRun& run) { return exact(residual_of(run, observable, member)); }};
}

Column counts(const char* name, std::size_t ReportRun::*member) {
  return {name, [member](const ReportRun& run) { return std::to_string(run.*member); }};
}

Column texts(const char* name, std::string ReportRun::*member) {
  return {name, [member](const ReportRun& run) { return csv_cell(run.*member); }};
}

const std::vector<Column>& columns() {
  using R = ReportResidual;
  static const std::vector<Column> all = {
      texts("name", &ReportRun::name),
      texts("kind", &ReportRun::kind),
      texts("video", &ReportRun::video),
      numbers("phi_rad", &ReportRun::phi_rad),
      numbers("dtau_rad", &ReportRun::dtau_rad),
      numbers("alpha_rad", &ReportRun::alpha_rad),
      numbers("alpha_rad_sd", &ReportRun::alpha_sd_rad),
      numbers("alpha_model_rad", &ReportRun::modelled_alpha_rad),
      numbers("v_mm_s", &ReportRun::v_mm_s),
      numbers("v_mm_s_sd", &ReportRun::v_sd_mm_s),
      numbers("v_model_mm_s", &ReportRun::modelled_v_mm_s),
      of_residual("dx_mm", "dx_mm", &R::measured),
      of_residual("dx_mm_sd", "dx_mm", &R::sd),
      of_residual("dx_model_mm", "dx_mm", &R::modelled),
      of_residual("dx_residual_sd", "dx_mm", &R::standardised),
      of_residual("dy_mm", "dy_mm", &R::measured),
      of_residual("dy_mm_sd", "dy_mm", &R::sd),
      of_residual("dy_model_mm", "dy_mm", &R::modelled),
      of_residual("dy_residual_sd", "dy_mm", &R::standardised),
      {"cycles", [](const ReportRun& run) { return run.cycles > 0 ? std::to_string(run.cycles) : ""; }},
      of_platform("amplitude_mm", &ReportPlatform::amplitude_mm),
      of_platform("amplitude_mm_sd", &ReportPlatform::amplitude_sd_mm),
      of_platform("angular_frequency_rad_s", &ReportPlatform::w_rad_s),
      of_platform("angular_frequency_rad_s_sd", &ReportPlatform::w_sd_rad_s),
      of_platform("phase_shift_rad", &ReportPlatform::epsilon_rad),
      of_platform("phase_shift_rad_sd", &ReportPlatform::epsilon_sd_rad),
      counts("frames_ok", &ReportRun::frames_ok),
      counts("frames_lost", &ReportRun::frames_lost),
      counts("frames_edge", &ReportRun::frames_edge),
      numbers("frame_rate_hz", &ReportRun::frame_rate_hz),
      numbers("sigma_px", &ReportRun::sigma_px),
      texts("failure", &ReportRun::failure)};
  return all;
}

}  // namespace

std::string runs_csv(const ReportData& data) {
  std::string csv = "number";
  for (const Column& column : columns()) csv.append(",").append(column.name);
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    csv += fmt::format("\n{}", i + 1);
    for (const Column& column : columns()) csv.append(",").append(column.cell(data.runs[i]));
  }
  return csv + "\n";
}

std::string parameters_csv(const ReportData& data) {
  std::string csv =
      "parameter,estimate,sd,ci95_low,ci95_high,covariance_ci95_low,covariance_ci95_high,profile_ci95_low,"
      "profile_ci95_high";
  for (const ReportParameter& p : data.parameters) csv += ",correlation_with_" + p.name;
  csv += "\n";
  for (std::size_t i = 0; i < data.parameters.size(); ++i) {
    const ReportParameter& p = data.parameters[i];
    csv += fmt::format("{},{},{}", p.name, exact(p.estimate), exact(p.sd));
    // An open end is no number: an empty cell.
    for (const ReportInterval& range : {p.ci95, p.covariance_ci95, p.profile_ci95})
      csv += fmt::format(",{},{}", exact(range.low), exact(range.high));
    for (std::size_t k = 0; k < data.parameters.size(); ++k)
      csv +=
          "," + (i < data.correlation.size() && k < data.correlation[i].size() ? exact(data.correlation[i][k])
                                                                               : "");
    csv += "\n";
  }
  return csv;
}

namespace {

std::string unit_of(const ReportParameter& p) {
  const std::string unit = parameter_text(p.name).unit;
  return unit.empty() ? "" : " " + unit;
}

std::string values(const ReportData& data) {
  std::string text;
  for (const ReportParameter& p : data.parameters)
    text += fmt::format("  {:<14} {:>20}{}   95 %: {}\n", p.name, quoted(p.estimate, p.sd), unit_of(p),
                        quoted_interval(p));
  for (std::size_t i = 0; i < data.correlation.size(); ++i)
    for (std::size_t k = 0; k < i && k < data.correlation[i].size(); ++k)
      text += fmt::format("  correlation of {} and {}: {:.2f}\n", data.parameters[i].name,
                          data.parameters[k].name, data.correlation[i][k]);
  return text;
}

std::string goodness(const ReportData& data) {
  if (!std::isfinite(data.chi2)) return "";
  std::string text = fmt::format("  chi2 = {:.4g} with {} degrees of freedom", data.chi2, data.dof);
  if (std::isfinite(data.p_value) && data.dof > 0)
    text += data.p_value > 0 ? fmt::format(", p = {:.2g} (threshold 0.001)", data.p_value)
                             : ", p < 1e-300 (threshold 0.001)";
  return text + "\n";
}

std::string budget(const ReportData& data) {
  std::string text;
  for (const ReportBudgetEntry& entry : data.budget) {
    if (!entry.counted) continue;
    text += fmt::format("  {:<34}", entry.source);
    for (std::size_t i = 0; i < data.parameters.size() && i < entry.contribution.size(); ++i)
      text += fmt::format(" {:>14}", rounded_to_sd(entry.contribution[i], std::abs(entry.contribution[i])));
    text += "\n";
  }
  if (text.empty()) return "";
  std::string head = fmt::format("uncertainty budget, sd given to each parameter\n  {:<34}", "source");
  for (const ReportParameter& p : data.parameters) head += fmt::format(" {:>14}", p.name);
  return head + "\n" + text + "\n";
}

}  // namespace

std::string report_text(const ReportData& data) {
  std::string text = data.title + "\n" + subtitle_of(data) + "\n\n" + plain_text(verdict_of(data).heading) +
                     ". " + plain_text(verdict_of(data).paragraph) + "\n\n";
  if (data.fitted && !data.parameters.empty())
    text +=
        "parameters: value(sd of the last digits)\n" + values(data) + goodness(data) + "\n" + budget(data);
  if (!data.warnings.empty()) {
    text += "warnings\n";
    for (const std::string& warning : data.warnings) text += "  - " + warning + "\n";
    text += "\n";
  }
  text += "methods\n  " + methods_text(data) + "\n\nto cite\n";
  for (const std::string& source : sources_to_cite(data)) text += "  " + source + "\n";
  return text;
}

}  // namespace tribotrack::apps
