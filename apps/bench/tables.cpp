#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/bench/page.h"
#include "apps/page/text.h"

namespace tribotrack::bench {

using apps::Json;

namespace {

/// On the page; "-" for what is not finite.
std::string cell_html(const Json& value) {
  if (!value.is_number()) return apps::cell(apps::sentence_html(apps::cell_text(value)));
  const auto number = value.get<double>();
  return fmt::format("<td class=\"n\" data-v=\"{}\">{}</td>", apps::cell_text(value),
                     std::isfinite(number) ? fmt::format("{:.4g}", number) : "-");
}

template <class Row, class RowOf>
std::vector<Json> rows_of(const std::vector<Row>& rows, const RowOf& row_of) {
  std::vector<Json> objects;
  for (const Row& row : rows) objects.push_back(row_of(row));
  return objects;
}

}  // namespace

std::string Table::html() const {
  std::vector<std::string> headings;
  std::string html;
  for (const Json& row : rows) {
    html += "<tr>";
    for (const auto& [column, value] : row.items()) {
      html += cell_html(value);
      if (headings.size() == row.size()) continue;
      std::string words = column;
      std::ranges::replace(words, '_', ' ');
      headings.push_back((value.is_number() ? ">" : "") + apps::sentence_html(words));
    }
    html += "</tr>\n";
  }
  return apps::table(name, "compact", headings, html);
}

Table table_of(const Comparison& comparison) {
  return {"bench_" + comparison.name, rows_of(comparison.rows, [&](const ComparedRow& r) {
            Json row = {{"group", r.group},   {"scene", r.scene == r.group ? "" : r.scene},
                        {"method", r.method}, {"setting", r.setting},
                        {"ours", r.ours},     {"arrived", r.arrived},
                        {"error", r.error},   {"error_unit", comparison.unit},
                        {"time_s", r.time}};
            for (const Detail& detail : r.details) row[detail.name] = detail.value;
            return row;
          })};
}

Table table_of(const std::vector<ExtremeRow>& rows) {
  return {"bench_model_extremes", rows_of(rows, [](const ExtremeRow& r) {
            return Json{{"case", r.name},
                        {"law", r.law},
                        {"held", r.held},
                        {"violation", r.violation},
                        {"allowed", r.allowed},
                        {"derivatives_finite", r.derivatives_finite},
                        {"steps", r.steps},
                        {"time_s", r.time},
                        {"time_per_cycle_over_ordinary", r.ratio_per_cycle},
                        {"failure", r.failure}};
          })};
}

Table table_of(const std::vector<OmissionRow>& rows) {
  return {"bench_model_plan", rows_of(rows, [](const OmissionRow& r) {
            return Json{{"omission", r.omission},     {"scene", r.scene},
                        {"time_with_s", r.time_with}, {"time_without_s", r.time_without},
                        {"saving", r.saving()},       {"difference_m", r.error}};
          })};
}

Table table_of(const std::vector<CoverageRow>& rows) {
  return {"bench_fit_coverage", rows_of(rows, [](const CoverageRow& r) {
            return Json{{"design", to_string(r.design)},
                        {"noise", to_string(r.level)},
                        {"parameter", r.parameter},
                        {"campaigns", r.campaigns},
                        {"usable", r.usable},
                        {"weak", r.weak},
                        {"open", r.open},
                        {"covered", r.share()},
                        {"covered_low", r.share_ci95().low},
                        {"covered_high", r.share_ci95().high}};
          })};
}

Table table_of(const std::vector<LaboratoryRow>& rows) {
  return {"bench_fit_laboratory", rows_of(rows, [](const LaboratoryRow& r) {
            return Json{{"fault", r.fault},
                        {"alpha_sd_rad", r.errors.alpha},
                        {"v_sd", r.errors.v},
                        {"campaigns", r.campaigns},
                        {"use", r.use},
                        {"care", r.care},
                        {"intervals", r.intervals},
                        {"held", r.held},
                        {"wrong", r.wrong},
                        {"rejected", r.rejected},
                        {"named", r.named}};
          })};
}

Table table_of(const std::vector<SummaryLine>& lines) {
  return {"bench_summary", rows_of(lines, [](const SummaryLine& l) {
            return Json{{"measured", l.measured},
                        {"tribotrack", l.ours},
                        {"best_of_others", l.peer},
                        {"who_wins", l.who}};
          })};
}

}  // namespace tribotrack::bench
