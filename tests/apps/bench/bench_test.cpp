// tribotrack bench as a user calls it, and the page on which its rows stand.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "apps/bench/page.h"
#include "apps/program.h"

namespace tribotrack::bench {
namespace {

bool holds(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

Comparison comparison_of(std::vector<ComparedRow> rows) {
  return {"model", "Error", "error", "m", "CPU time", "truth", 1e-8, std::move(rows)};
}

ComparedRow row(const char* method, bool ours, double error, double time) {
  ComparedRow made{"group", "scene", method, "", ours};
  made.error = error;
  made.time = time;
  made.details = {{"steps", 7}};
  return made;
}

const ComparedRow kRough = row("ours", true, 1e-9, 1e-5), kFine = row("ours", true, 1e-12, 4e-5);

TEST(Comparison, SummaryNamesTheBestOfOthersAtTheTarget) {
  const auto lines =
      summary_of(comparison_of({kRough, kFine, row("slow", false, 1e-9, 1e-3),
                                row("quick", false, 5e-9, 5e-6), row("rough", false, 1e-3, 1e-9)}));
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].ours, "10 us, 1e-09 m (ours)");
  EXPECT_EQ(lines[0].peer, "5 us, 5e-09 m (quick)");
  EXPECT_EQ(lines[0].who, "PEER WINS on time x2.00");
}

TEST(BenchTables, HaveOneListOfColumns) {
  const Table table = table_of(comparison_of({kRough, row("quick, \"rough\" <b>", false, 1.25e-9, 5e-6)}));
  EXPECT_TRUE(
      table.csv().starts_with("group,scene,method,setting,ours,arrived,error,error_unit,time_s,steps\n"
                              "group,scene,ours,,yes,yes,1e-09,m,1e-05,7\n"));
  EXPECT_TRUE(holds(table.csv(), "\"quick, \"\"rough\"\" <b>\""));
  EXPECT_TRUE(holds(table.html(), "quick, &quot;rough&quot; &lt;b&gt;"));
  EXPECT_TRUE(holds(table.html(), "<td class=\"n\" data-v=\"5e-06\">5e-06</td>"));
}

TEST(BenchPage, ShowsWhatWasRun) {
  BenchResults results;
  results.comparisons = {comparison_of({kRough, row("quick", false, 1e-9, 5e-6)})};
  results.extremes.resize(2);
  results.extremes[0].name = "case A";
  results.extremes[0].held = true;
  results.extremes[1].name = "case B";
  results.extremes[1].law = "law of B";
  const std::string page = page_of(results, circumstances_here());
  for (const char* part :
       {"<table id=\"bench_summary\"", "<td>1 of 2</td><td>-</td><td>BROKEN: see the table</td>",
        "<b>BROKEN</b>: case B: law of B", "id=\"figure-model-error-time\"", "<th>compiler_flags</th>"})
    EXPECT_TRUE(holds(page, part)) << part;
  EXPECT_FALSE(holds(page, "<section id=\"coverage\""));
  const apps::Figure figure = figures_of(results).at(0);
  EXPECT_EQ(figure.panels.at(0).traces.at(0)["x"][0], 1e-5);
  EXPECT_EQ(figure.panels[0].y["range"][0], -9);
}

class BenchCommand : public apps::ProgramTest {};

TEST_F(BenchCommand, AllQuickWritesEveryTableItsMetaFileAndThePage) {
  const apps::Outcome outcome = run("bench all --quick --campaigns 1 -o out");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::filesystem::path out = in_folder("out");
  for (const char* name : {"bench_model", "bench_model_extremes", "bench_model_plan", "bench_vision",
                           "bench_fit", "bench_fit_coverage", "bench_fit_laboratory"}) {
    EXPECT_TRUE(std::filesystem::exists(out / (std::string(name) + ".csv"))) << name;
    EXPECT_TRUE(std::filesystem::exists(out / (std::string(name) + ".csv.meta.json"))) << name;
    EXPECT_TRUE(holds(outcome.out, std::string(name) + ".csv\n")) << name;
  }
  const std::string page = apps::content_of(out / "bench.html");
  for (const char* section :
       {"model", "extremes", "omissions", "vision", "fit", "coverage", "laboratory", "circumstances"})
    EXPECT_TRUE(holds(page, "<section id=\"" + std::string(section))) << section;
  EXPECT_TRUE(holds(outcome.err, "Who wins where"));
  const auto json = nlohmann::json::parse(apps::content_of(out / "bench.json"));
  for (const char* key : {"cpu", "compiler", "compiler_flags", "reference", "results"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["results"]["model"]["laws_broken"], 0);
}

}  // namespace
}  // namespace tribotrack::bench
