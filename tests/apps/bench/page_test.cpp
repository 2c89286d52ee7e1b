#include "apps/bench/page/page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "apps/bench/page/summary.h"
#include "apps/bench/page/wins.h"
#include "apps/page/text.h"

namespace tribotrack::bench {
namespace {

Circumstances here() {
  Circumstances c;
  c.program = "tribotrack 9";
  c.cpu = "a <fast> processor";
  c.compiler = "GNU 12";
  c.missing = {"SUNDIALS"};
  c.load_before = {{0.5, 1, 2}};
  return c;
}

ModelBenchRow model_row(const std::string& method, double time, double error, double time_over_ours) {
  ModelBenchRow row;
  row.scene = "always slipping";
  row.method = method;
  row.ours = std::isnan(time_over_ours);
  row.time = time;
  row.error = error;
  row.time_over_ours = time_over_ours;
  return row;
}

BenchResults of_model() {
  BenchResults results;
  ModelResults& model = results.model.emplace();
  model.rows = {model_row("tribotrack (every cycle)", 1e-5, 1e-12, NAN),
                model_row("quick & rough", 5e-6, 1e-9, 0.5), model_row("slow", 1e-3, 1e-9, 100)};
  for (const auto& [name, held] : {std::pair("case A", true), {"case B", false}}) {
    ModelExtremeRow row;
    row.name = name;
    row.invariant = std::string("law of ") + name;
    row.held = held;
    row.violation = held ? 1e-15 : 0.5;
    model.extremes.push_back(row);
  }
  return results;
}

std::string page_of(const BenchResults& results) {
  return page_of(results, tables_of(results, {}), here());
}

bool holds(const std::string& page, std::string_view text) {
  return page.find(text) != std::string::npos;
}

TEST(BenchPage, BeginsWithThreeSentencesAndWhoWins) {
  const std::string page = page_of(of_model());
  EXPECT_EQ(kReadingGuide.size(), 3U);
  for (const std::string_view sentence : kReadingGuide) {
    EXPECT_TRUE(holds(page, apps::escape_html(sentence)));
    EXPECT_EQ(std::ranges::count(sentence, '.'), 1) << sentence;
    EXPECT_TRUE(sentence.ends_with('.'));
  }
  EXPECT_TRUE(holds(page, "<h1>Error against run time</h1>"));
  EXPECT_TRUE(holds(page, "tribotrack 9, a &lt;fast&gt; processor, GNU 12"));
  EXPECT_TRUE(holds(page, "<table id=\"bench_summary\""));
}

TEST(BenchPage, ShowsTheVerdictOfEachExtremeCase) {
  const std::string page = page_of(of_model());
  EXPECT_TRUE(holds(page, "<tr><td>case A</td><td>law of case A</td><td>held</td>"));
  EXPECT_TRUE(holds(page, "<tr><td>case B</td><td>law of case B</td><td>BROKEN</td>"));
  EXPECT_TRUE(holds(page, "1 of 2 stiff and extreme cases"));
  EXPECT_TRUE(holds(page, "<b>BROKEN</b>: case B: law of case B"));
}

TEST(BenchPage, ShowsWhereAPeerWins) {
  BenchResults results = of_model();
  const auto lines = summary_of(results);
  EXPECT_EQ(lines.at(0).ours, "10 µs");
  EXPECT_EQ(lines.at(0).peer, "5 µs (quick & rough)");
  EXPECT_EQ(lines.at(0).who, "PEER WINS x2.00; of all settings of others 1 of 2 win");
  EXPECT_EQ(lines.at(1).ours, "1 of 2") << "laws";
  EXPECT_EQ(lines.at(1).who, "BROKEN: see the table");
  const std::string page = page_of(results);
  EXPECT_TRUE(holds(page, "<td>quick &amp; rough</td><td>1 of 1</td>"));
  EXPECT_TRUE(holds(page, "PEER WINS, up to x2.00 faster"));

  results.model->rows.at(1).time_over_ours = 2;
  EXPECT_TRUE(holds(wins_of_peers(results.model->rows), "Nowhere"));
  results.model->rows.at(1).time_over_ours = 0;
  EXPECT_TRUE(holds(wins_of_peers(results.model->rows), "more accurate than any of ours"));
}

TEST(BenchPage, ShowsWhereAFitOfOthersWins) {
  std::vector<FitBenchRow> rows(3);
  for (FitBenchRow& row : rows) {
    row.data = "14 tracks";
    row.campaigns = row.converged = 2;
  }
  rows[0].method = "tribotrack";
  rows[0].ours = true;
  rows[0].time = 1;
  rows[1].method = "sooner";
  rows[1].time = 0.25;
  rows[2].method = "elsewhere";
  rows[2].time = 0.1;
  rows[2].off_minimum = 3;
  const std::string html = wins_of_peers(rows);
  EXPECT_TRUE(holds(html, "PEER WINS x4.00")) << html;
  EXPECT_FALSE(holds(html, "elsewhere")) << "what ends off the minimum does not win";
}

TEST(BenchPage, LeavesOutWhatWasNotRunAndSaysSo) {
  const std::string page = page_of(of_model());
  EXPECT_TRUE(
      holds(page,
            "Not run for this page: tracking on rendered scenes and the audit, whole commands, the fit "
            "and what intervals cover"));
  for (const char* section : {"model", "extremes", "plan", "batch", "claims", "circumstances"})
    EXPECT_TRUE(holds(page, std::string("<section id=\"") + section)) << section;
  for (const char* section : {"tracking", "audit", "fit", "coverage"})
    EXPECT_FALSE(holds(page, std::string("<section id=\"") + section)) << section;
  BenchResults results;
  results.commands.emplace();
  EXPECT_TRUE(holds(page_of(results), "<section id=\"tracking\""));
}

TEST(BenchPage, ShowsTheAuditsHalves) {
  BenchResults results;
  VisionLimitRow row;
  row.radius = 10;
  row.rms = row.bound = 1;
  row.audit.halves_x = 1.03;
  row.audit.checkerboard = 0.98;
  results.vision.emplace().limits = {row};
  const std::string page = page_of(results);
  EXPECT_TRUE(holds(page, "<table id=\"bench_vision_audit\""));
  EXPECT_TRUE(holds(page, "data-v=\"1.03\">1.030</td>"));
  EXPECT_TRUE(holds(page, "data-v=\"0.98\">0.980</td>"));
}

TEST(BenchPage, NamesMachineReferencesAndWhatIsMissing) {
  const std::string page = page_of(of_model());
  EXPECT_TRUE(holds(page, "<th>load before</th><td>0.50, 1.00, 2.00</td>"));
  EXPECT_TRUE(holds(page, "this build was made without SUNDIALS"));
  EXPECT_EQ(page_of(of_model()), page) << "the same results give the same page";
  const Circumstances now = circumstances_here();
  EXPECT_FALSE(now.compiler.empty());
  EXPECT_FALSE(now.model_reference.empty());
}

}  // namespace
}  // namespace tribotrack::bench
