#include "apps/bench/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/text.h"
#include "apps/text/csv_table.h"
#include "apps/text/number_text.h"

namespace tribotrack::bench {

namespace {

/// Letters of UTF-8: each begins with a byte that continues none.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

Cell word(const std::string& text) {
  return {text, apps::csv_cell(text)};
}

/// "-" and an empty cell in the CSV for what is not finite.
Cell number(double value, const char* format = "{:.3g}") {
  if (!std::isfinite(value)) return {"-", "", true};
  return {fmt::format(fmt::runtime(format), value), apps::compact(value), true};
}

Cell seconds(double value) {
  return {time_text(value), apps::compact(value), true};
}

Cell percent(double share) {
  return {fmt::format("{:.1f} %", 100 * share), apps::compact(share), true};
}

Cell yes(bool value) {
  const char* word = value ? "yes" : "no";
  return {word, word};
}

}  // namespace

std::string Table::csv() const {
  const auto line = [this](const auto& text_of) {
    std::string out;
    for (std::size_t k = 0; k < names.size(); ++k)
      if (!names[k].empty()) out += (out.empty() ? "" : ",") + text_of(k);
    return out + "\n";
  };
  std::string out = line([this](std::size_t k) { return names[k]; });
  for (const auto& row : rows) out += line([&row](std::size_t k) { return row[k].exact; });
  return out;
}

std::string Table::text() const {
  std::vector<std::size_t> widths;
  for (std::size_t k = 0; k < headings.size(); ++k) {
    widths.push_back(width_of(headings[k]));
    for (const auto& row : rows) widths[k] = std::max(widths[k], width_of(row[k].text));
  }
  const auto line = [&](const auto& text_of) {
    std::string out;
    for (std::size_t k = 0; k < headings.size(); ++k) {
      if (headings[k].empty()) continue;
      const std::string text = text_of(k), blanks(widths[k] - width_of(text), ' ');
      const bool right = !rows.empty() && rows.front()[k].number;
      out += "  " + (right ? blanks + text : text + blanks);
    }
    return out.substr(0, out.find_last_not_of(' ') + 1) + "\n";
  };
  std::string out = "\n" + title + "\n" + line([this](std::size_t k) { return headings[k]; });
  for (const auto& row : rows) out += line([&row](std::size_t k) { return row[k].text; });
  return out;
}

std::string Table::html() const {
  std::vector<std::string> shown;
  for (std::size_t k = 0; k < headings.size(); ++k)
    if (!headings[k].empty())
      shown.push_back((!rows.empty() && rows.front()[k].number ? ">" : "") +
                      apps::sentence_html(headings[k]));
  std::string html;
  for (const auto& row : rows) {
    html += "<tr>";
    for (std::size_t k = 0; k < headings.size(); ++k) {
      if (headings[k].empty()) continue;
      std::string text = apps::sentence_html(row[k].text);
      if (text.ends_with(" us")) text.replace(text.size() - 2, 2, "µs");
      html += row[k].number ? fmt::format("<td class=\"n\" data-v=\"{}\">{}</td>", row[k].exact, text)
                            : apps::cell(text);
    }
    html += "</tr>\n";
  }
  return apps::table(name, "compact", shown, html);
}

Table table_of(const Comparison& comparison) {
  using Row = ComparedRow;
  std::vector<Column<Row>> columns{
      {"group", "group", [](const Row& r) { return word(r.group); }},
      {"scene", "scene", [](const Row& r) { return word(r.scene == r.group ? "" : r.scene); }},
      {"method", "method", [](const Row& r) { return word(r.method); }},
      {"setting", "setting", [](const Row& r) { return word(r.setting); }},
      {"ours", "", [](const Row& r) { return yes(r.ours); }},
      {"arrived", "arrived", [](const Row& r) { return yes(r.arrived); }},
      {"error", comparison.error, [](const Row& r) { return number(r.error); }},
      {"error_unit", "unit", [&](const Row&) { return word(comparison.unit); }},
      {"time_s", "time", [](const Row& r) { return seconds(r.time); }}};
  if (!comparison.rows.empty())
    for (const Detail& detail : comparison.rows.front().details) {
      std::string heading = detail.name;
      std::ranges::replace(heading, '_', ' ');
      columns.push_back({detail.name, heading,
                         [name = detail.name](const Row& r) { return number(r.at(name), "{:.4g}"); }});
    }
  return {"bench_" + comparison.name, comparison.title + " (" + comparison.time + ")", comparison.rows,
          columns};
}

Table table_of(const std::vector<ExtremeRow>& rows) {
  using Row = ExtremeRow;
  return {
      "bench_model_extremes",
      "Stiff and extreme cases",
      rows,
      {{"case", "case", [](const Row& r) { return word(r.name); }},
       {"law", "law that must hold", [](const Row& r) { return word(r.law); }},
       {"held", "verdict",
        [](const Row& r) {
          return Cell{r.held ? "held" : "BROKEN", r.held ? "yes" : "no"};
        }},
       {"violation", "violated by", [](const Row& r) { return number(r.violation, "{:.1e}"); }},
       {"allowed", "allowed", [](const Row& r) { return number(r.allowed, "{:.1e}"); }},
       {"derivatives_finite", "derivatives finite", [](const Row& r) { return yes(r.derivatives_finite); }},
       {"steps", "steps", [](const Row& r) { return number(static_cast<double>(r.steps), "{:.0f}"); }},
       {"time_s", "time", [](const Row& r) { return seconds(r.time); }},
       {"time_per_cycle_over_ordinary", "time per cycle, x ordinary",
        [](const Row& r) { return number(r.ratio_per_cycle, "{:.2f}"); }},
       {"failure", "failure", [](const Row& r) { return word(r.failure); }}}};
}

Table table_of(const std::vector<OmissionRow>& rows) {
  using Row = OmissionRow;
  return {"bench_model_plan",
          "What omissions save: the same motion with and without",
          rows,
          {{"omission", "left out", [](const Row& r) { return word(r.omission); }},
           {"scene", "scene", [](const Row& r) { return word(r.scene); }},
           {"time_with_s", "with", [](const Row& r) { return seconds(r.time_with); }},
           {"time_without_s", "without", [](const Row& r) { return seconds(r.time_without); }},
           {"saving", "saved", [](const Row& r) { return percent(r.saving()); }},
           {"difference_m", "ends apart, m", [](const Row& r) { return number(r.error, "{:.1e}"); }}}};
}

Table table_of(const std::vector<CoverageRow>& rows) {
  using Row = CoverageRow;
  return {"bench_fit_coverage",
          "95 % intervals that hold the truth",
          rows,
          {{"design", "design", [](const Row& r) { return word(to_string(r.design)); }},
           {"noise", "noise", [](const Row& r) { return word(to_string(r.level)); }},
           {"parameter", "parameter", [](const Row& r) { return word(r.parameter); }},
           {"campaigns", "campaigns", [](const Row& r) { return number(r.campaigns, "{}"); }},
           {"usable", "usable", [](const Row& r) { return number(r.usable, "{}"); }},
           {"weak", "weak", [](const Row& r) { return number(r.weak, "{}"); }},
           {"open", "open", [](const Row& r) { return number(r.open, "{}"); }},
           {"covered", "covered", [](const Row& r) { return percent(r.share()); }},
           {"covered_low", "from", [](const Row& r) { return percent(r.share_ci95().low); }},
           {"covered_high", "to (95 %)", [](const Row& r) { return percent(r.share_ci95().high); }}}};
}

Table table_of(const std::vector<LaboratoryRow>& rows) {
  using Row = LaboratoryRow;
  const auto count = [](int Row::*of) { return [of](const Row& r) { return number(r.*of, "{}"); }; };
  return {"bench_fit_laboratory",
          "Laboratories that are not the model",
          rows,
          {{"fault", "what is not said", [](const Row& r) { return word(r.fault); }},
           {"alpha_sd_rad", "sd of alpha, rad", [](const Row& r) { return number(r.errors.alpha); }},
           {"v_sd", "of v", [](const Row& r) { return percent(r.errors.v); }},
           {"campaigns", "campaigns", count(&Row::campaigns)},
           {"use", "use", count(&Row::use)},
           {"care", "care", count(&Row::care)},
           {"intervals", "intervals", count(&Row::intervals)},
           {"held", "that hold", count(&Row::held)},
           {"wrong", "use, but far out", count(&Row::wrong)},
           {"rejected", "rejected", count(&Row::rejected)},
           {"named", "fault named", count(&Row::named)}}};
}

Table table_of(const std::vector<SummaryLine>& lines) {
  using Row = SummaryLine;
  return {"bench_summary",
          "Who wins where",
          lines,
          {{"measured", "what was measured", [](const Row& r) { return word(r.measured); }},
           {"tribotrack", "tribotrack", [](const Row& r) { return word(r.ours); }},
           {"best_of_others", "the best of others", [](const Row& r) { return word(r.peer); }},
           {"who_wins", "who wins where", [](const Row& r) { return word(r.who); }}}};
}

}  // namespace tribotrack::bench
