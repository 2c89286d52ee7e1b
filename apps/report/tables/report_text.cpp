#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/text.h"
#include "apps/report/findings/methods_text.h"
#include "apps/report/findings/quoted.h"
#include "apps/report/findings/verdict.h"
#include "apps/report/tables/tables.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
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
