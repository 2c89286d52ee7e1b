#include "apps/bench/page/page.h"

#include <fmt/format.h>

#include "apps/bench/page/sections.h"
#include "apps/bench/page/summary.h"
#include "apps/figures/axes.h"
#include "apps/page/page.h"
#include "apps/page/text.h"

namespace tribotrack::bench {
namespace {

/// "a, b and c"
std::string list_of(const std::vector<std::string>& words) {
  std::string list;
  for (std::size_t k = 0; k < words.size(); ++k)
    list += (k == 0 ? "" : k + 1 == words.size() ? " and " : ", ") + words[k];
  return list;
}

std::string left_out(const BenchResults& results) {
  std::vector<std::string> missing;
  if (!results.model) missing.emplace_back("the model, its extremes and the paper’s claims");
  if (!results.vision) missing.emplace_back("tracking on rendered scenes and the audit");
  if (!results.commands) missing.emplace_back("whole commands");
  if (!results.fit) missing.emplace_back("the fit");
  if (!results.coverage) missing.emplace_back("what intervals cover");
  if (missing.empty()) return "";
  return fmt::format(
      "<p class=\"left-out\">Not run for this page: {} (<code>tribotrack bench all</code> runs "
      "everything).</p>\n",
      list_of(missing));
}

}  // namespace

const std::array<const char*, 3> kReadingGuide = {
    "In a figure of error against run time a point is one method at one setting, its run time to the right "
    "and its "
    "error upwards in powers of ten: nearer to the lower left corner is better, large dots are tribotrack, "
    "and a ring "
    "marks where a method of others wins.",
    "Errors are distances from a reference that was made in another way or is known because the data were "
    "simulated, "
    "and run times are CPU times, medians of repetitions in which the methods took turns on this machine.",
    "The table below sets our figure beside the best of the others and says who wins where; every row behind "
    "it "
    "stands in the tables of the sections, where PEER WINS marks what others do better.",
};

std::vector<apps::Figure> figures_of(const std::vector<BenchTable>& tables) {
  std::vector<apps::Figure> figures;
  for (const BenchTable& table : tables)
    figures.insert(figures.end(), table.figures.begin(), table.figures.end());
  for (apps::Figure& figure : figures) settle_axes(figure);
  return figures;
}

std::string page_of(const BenchResults& results, const std::vector<BenchTable>& tables,
                    const Circumstances& circumstances) {
  apps::Page page;
  page.name = "bench";
  page.title = "Error against run time";
  page.subtitle = fmt::format("{}, {}, {}", circumstances.program, circumstances.cpu, circumstances.compiler);
  if (const auto lines = summary_of(results); !lines.empty()) {  // there is somebody to compare with
    page.first = "<p>";
    for (const char* sentence : kReadingGuide) page.first += apps::escape_html(sentence) + " ";
    page.first += "</p>\n" + summary_table(lines);
  }
  page.first += left_out(results);
  page.sections = sections_of(results, tables);
  page.sections.push_back(section_of(circumstances));
  page.figures = figures_of(tables);
  return apps::html_of(std::move(page));
}

}  // namespace tribotrack::bench
