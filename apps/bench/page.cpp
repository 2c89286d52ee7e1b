#include "apps/bench/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <utility>

#include "apps/page/page.h"
#include "apps/page/text.h"

namespace tribotrack::bench {

using apps::Figure;

namespace {

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      if (const auto colon = line.find(": "); colon != std::string::npos) return line.substr(colon + 2);
  return "unknown";
}

/// Solvers of one library share an entry of the legend: a dozen colours cannot be told apart.
std::string legend_of(const std::string& method) {
  return method.starts_with("odeint ") || method.starts_with("CVODE ") ? method.substr(0, method.find(' '))
                                                                       : method;
}

/// Whole decades that hold the positive values.
apps::Json decades(const std::string& title, apps::Values values) {
  std::erase_if(values, [](double value) { return !(value > 0) || !std::isfinite(value); });
  if (values.empty()) return apps::plot::log_axis(title);
  const double low = std::floor(std::log10(std::ranges::min(values)));
  return apps::plot::log_axis(title, low, std::max(std::ceil(std::log10(std::ranges::max(values))), low + 1));
}

/// Where a method ends, a point at each of its settings; what has no logarithm is drawn at the lower edge.
Figure figure_of(const Comparison& comparison) {
  Figure figure{.id = comparison.name + "-error-time", .title = comparison.title, .caption = {}};
  figure.caption =
      "A point is a method at one setting on one scene; nearer to the lower left corner is better, large "
      "dots are tribotrack.";
  figure.alternative = comparison.title + ", a panel for each group of scenes over two logarithmic axes";
  apps::Values times, errors;
  for (const ComparedRow& row : comparison.rows) {
    times.push_back(row.time);
    errors.push_back(row.error);
  }
  const apps::Json x = decades(comparison.time + ", s", times);
  const apps::Json y =
      decades(comparison.error + (comparison.unit == "x limit" ? "" : ", " + comparison.unit), errors);
  std::vector<std::string> groups, legend;
  const auto add_new = [](std::vector<std::string>& list, const std::string& name) {
    if (std::ranges::find(list, name) == list.end()) list.push_back(name);
  };
  for (const ComparedRow& row : comparison.rows)
    if (row.arrived) {
      add_new(groups, row.group);
      add_new(legend, legend_of(row.method));
    }
  std::vector<bool> named(legend.size());
  for (const std::string& group : groups) {
    apps::Panel panel{.x = x, .y = y, .title = group};
    for (std::size_t k = 0; k < legend.size(); ++k) {
      apps::Values at, error;
      apps::Notes notes;
      bool ours = false;
      for (const ComparedRow& row : comparison.rows) {
        if (!row.arrived || row.group != group || legend_of(row.method) != legend[k]) continue;
        ours = row.ours;
        at.push_back(row.time);
        error.push_back(row.error > 0 ? row.error : std::pow(10, y["range"][0].get<double>()));
        notes.push_back(fmt::format("{} {}, {}: {:.2g} {}", row.method, row.setting, row.scene, row.error,
                                    comparison.unit));
      }
      if (at.empty()) continue;
      panel.traces.push_back(apps::plot::points(
          legend[k], at, error, {.colour = static_cast<int>(k), .legend = !named[k], .large = ours}, notes));
      named[k] = true;
    }
    figure.panels.push_back(panel);
  }
  figure.columns = figure.panels.size() > 1 ? 2 : 1;
  figure.height = 0.35 * std::ceil(static_cast<double>(figure.panels.size()) / figure.columns);
  return figure;
}

std::string paragraph(const std::string& text) {
  return "<p>" + apps::escape_html(text) + "</p>\n";
}

/// Long tables open on demand.
std::string folded(const Table& table) {
  return fmt::format("<details><summary>All {} rows</summary>{}</details>\n", table.rows.size(),
                     table.html());
}

std::string broken_laws(const std::vector<ExtremeRow>& rows) {
  std::string html;
  for (const ExtremeRow& row : rows)
    if (!row.held)
      html += fmt::format("<p><b>BROKEN</b>: {}: {}</p>\n", apps::escape_html(row.name),
                          apps::escape_html(row.failure.empty() ? row.law : row.failure));
  return html;
}

long held_in(const std::vector<ExtremeRow>& rows) {
  return std::ranges::count(rows, true, &ExtremeRow::held);
}

}  // namespace

Circumstances circumstances_here() {
  double load[3];
  return {
      {"program", "tribotrack " TRIBOTRACK_VERSION},
      {"cpu", cpu_name()},
      {"compiler", TRIBOTRACK_COMPILER},
      {"compiler_flags", TRIBOTRACK_COMPILER_FLAGS},
      {"clock", "CPU time of the measuring thread; medians of repetitions in which the methods take turns"},
      {"peers_missing", missing_library().empty() ? "none" : missing_library()},
      {"load_average", getloadavg(load, 3) == 3
                           ? fmt::format("{:.2f}, {:.2f}, {:.2f}", load[0], load[1], load[2])
                           : "unknown"}};
}

namespace {

void add_laboratory(const std::vector<LaboratoryRow>& rows, std::vector<SummaryLine>& lines) {
  LaboratoryRow all, single;  // single: one fault, which a fit can name
  for (const LaboratoryRow& row : rows) {
    all.use += row.use;
    all.intervals += row.intervals;
    all.held += row.held;
    all.wrong += row.wrong;
    if (row.fault == kFaults[0] || row.fault == kFaults[1]) continue;
    single.rejected += row.rejected;
    single.named += row.named;
  }
  const auto add = [&](const char* what, int part, int whole, const char* wanted) {
    if (whole > 0)
      lines.push_back({std::string("laboratories that are not the model: ") + what,
                       fmt::format("{:.1f} % of {}", 100.0 * part / whole, whole), wanted, "-"});
  };
  add("intervals that hold", all.held, all.intervals, "90 to 97 % is right");
  add("\"use\" over a value far outside its interval", all.wrong, all.use, "3 % at most");
  add("rejected ones whose fault is named", single.named, single.rejected, "85 % at least");
}

}  // namespace

std::vector<SummaryLine> summary_of(const BenchResults& results) {
  std::vector<SummaryLine> lines;
  for (const Comparison& comparison : results.comparisons)
    for (const SummaryLine& line : summary_of(comparison)) lines.push_back(line);
  if (const auto count = static_cast<long>(results.extremes.size()); count > 0)
    lines.push_back({"stiff and extreme cases: laws that hold",
                     fmt::format("{} of {}", held_in(results.extremes), count), "-",
                     held_in(results.extremes) == count ? "all held" : "BROKEN: see the table"});
  long covered = 0, usable = 0, off = 0;
  for (const CoverageRow& row : results.coverage) {
    covered += row.covered;
    usable += row.usable;
    off += row.usable > 0 && (row.share_ci95().high < 0.95 || row.share_ci95().low > 0.95);
  }
  if (usable > 0)
    lines.push_back(
        {"95 % intervals that hold the truth",
         fmt::format("{:.1f} % of {}", 100 * double(covered) / double(usable), usable), "95 % is right",
         fmt::format("of {} kinds {} lie beyond chance (1 in 20 would)", results.coverage.size(), off)});
  add_laboratory(results.laboratory, lines);
  return lines;
}

std::vector<Table> tables_of(const BenchResults& results) {
  std::vector<Table> tables;
  for (const Comparison& comparison : results.comparisons) tables.push_back(table_of(comparison));
  if (!results.extremes.empty()) tables.push_back(table_of(results.extremes));
  if (!results.omissions.empty()) tables.push_back(table_of(results.omissions));
  if (!results.coverage.empty()) tables.push_back(table_of(results.coverage));
  if (!results.laboratory.empty()) tables.push_back(table_of(results.laboratory));
  return tables;
}

std::vector<Figure> figures_of(const BenchResults& results) {
  std::vector<Figure> figures;
  for (const Comparison& comparison : results.comparisons) figures.push_back(figure_of(comparison));
  return figures;
}

std::string page_of(const BenchResults& results, const Circumstances& circumstances) {
  apps::Page page;
  page.name = "bench";
  page.title = "Error against run time";
  page.first =
      paragraph(
          "Errors are distances from a reference that was made in another way or is known because the data "
          "were simulated; run times are CPU times. In each group of scenes the best row of tribotrack as "
          "users get it is set against the best of others: the fastest that reach the error named or, where "
          "none is named, the most accurate; PEER WINS marks what others do better.") +
      table_of(summary_of(results)).html();
  page.figures = figures_of(results);
  for (const Comparison& comparison : results.comparisons)
    page.sections.push_back({comparison.name, comparison.title,
                             paragraph("Reference: " + comparison.reference + ".") +
                                 figure_box(page.figures, comparison.name + "-error-time") +
                                 folded(table_of(comparison))});
  if (!results.extremes.empty())
    page.sections.push_back(
        {"extremes", "Stiff and extreme cases",
         paragraph("Each must hold a law: a scaling, a closed solution, a bound. The figure is how far it is "
                   "from holding, relative to the path unless the law says otherwise.") +
             broken_laws(results.extremes) + folded(table_of(results.extremes))});
  const auto add = [&](const auto& rows, const char* name, const char* title, const char* what) {
    if (!rows.empty()) page.sections.push_back({name, title, paragraph(what) + table_of(rows).html()});
  };
  add(results.omissions, "omissions", "What omissions save",
      "The same motion with and without machinery that it does not need.");
  add(results.coverage, "coverage", "Coverage",
      "Do 95 % intervals hold the truth in 95 % of simulated campaigns? Counted are those whose fit calls "
      "itself usable, with the binomial 95 % range (Clopper and Pearson).");
  add(results.laboratory, "laboratory", "Laboratories that are not the model",
      "Campaigns of a platform and a friction that depart from the model, simulated by another integrator "
      "and fitted as a table of which nobody says how well anything is known. What is not said: nothing; all "
      "the usual departures together; or one of one to six times the sd by which a fit expects it. Far out: "
      "outside the 95 % interval by more than a quarter of its length.");
  std::string html = "<div class=\"wide\"><table id=\"bench_circumstances\" class=\"compact\"><tbody>\n";
  for (const auto& [name, value] : circumstances)
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, apps::escape_html(value));
  page.sections.push_back({"circumstances", "Circumstances", html + "</tbody></table></div>\n"});
  return apps::html_of(std::move(page));
}

apps::Json json_of(const BenchResults& results, const Circumstances& circumstances) {
  apps::Json json = apps::Json::object();
  for (const auto& [name, value] : circumstances) json[name] = value;
  for (const Comparison& comparison : results.comparisons) {
    json["reference"][comparison.name] = comparison.reference;
    json["results"][comparison.name]["rows"] = comparison.rows.size();
  }
  if (const auto count = static_cast<long>(results.extremes.size()); count > 0) {
    json["results"]["model"]["extremes"] = count;
    json["results"]["model"]["laws_broken"] = count - held_in(results.extremes);
  }
  if (!results.omissions.empty()) json["results"]["model"]["omissions"] = results.omissions.size();
  if (!results.coverage.empty()) json["results"]["fit"]["coverage"] = results.coverage.size();
  if (!results.laboratory.empty()) json["results"]["fit"]["laboratory"] = results.laboratory.size();
  return json;
}

}  // namespace tribotrack::bench
