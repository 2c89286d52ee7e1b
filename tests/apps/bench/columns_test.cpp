#include "apps/bench/tables/columns.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tribotrack::bench {
namespace {

struct Row {
  std::string scene, method;
  double error = 0, time = 0;
};

const Columns<Row>& columns() {
  static const Columns<Row> list{
      {"scene", &Row::scene},
      {"method", &Row::method, "method", "<12"},
      {"error_m", &Row::error, "error, m", ">9", "{:.1e}"},
      {"time_s", seconds(&Row::time), "time", ">9"},
      {"reference", &Row::scene},
      {"", [](const Row& row) { return row.error > 0 ? "worse" : ""; }, " verdict", "<", " {}"},
  };
  return list;
}

long count(const std::string& text, const std::string& what) {
  long found = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

TEST(Columns, HtmlHasACellForEachColumnOfTheText) {
  const std::vector<Row> rows{{"flat", "a", 1.25e-7, 3.5e-6}, {"flat", "b", 0, 2e-3}};
  const std::string html = columns().html("t_1", rows);
  EXPECT_NE(html.find("<table id=\"t_1\" class=\"compact\">"), std::string::npos) << html;
  EXPECT_TRUE(html.starts_with("<div class=\"wide\">"));
  EXPECT_EQ(count(html, "<th"), 1 + 4) << "thead and a heading for each column";
  EXPECT_EQ(count(html, "<tr>"), 3);
  EXPECT_EQ(count(html, "<td"), 2 * 4);
  EXPECT_NE(html.find("<th class=\"n\">error, m</th>"), std::string::npos);
  EXPECT_NE(html.find("<td>worse</td>"), std::string::npos) << "without the text's blank before it";
}

TEST(Columns, HtmlKeepsTheDigitsOfTheCsvBehindRoundedNumbers) {
  const std::string html = columns().html("t", {{"s", "m", 1.25e-7, 3.5e-6}});
  EXPECT_NE(html.find("<td class=\"n\" data-v=\"1.25e-07\">1.2e-07</td>"), std::string::npos) << html;
  EXPECT_NE(html.find("<td class=\"n\" data-v=\"3.5e-06\">3.5 µs</td>"), std::string::npos) << html;
}

TEST(Columns, HtmlEscapesWhatIsWrittenIntoIt) {
  const std::string html = columns().html("t", {{"s", "<b>\"&'", 0, 0}});
  EXPECT_NE(html.find("<td>&lt;b&gt;&quot;&amp;&#39;</td>"), std::string::npos) << html;
}

TEST(Columns, HtmlShowsColumnsOfTheCsvAloneWhereAsked) {
  const std::string html = columns().html("t", {{"steep", "m", 0, 0}}, {"scene"});
  EXPECT_NE(html.find("<tr><th>scene</th><th>method</th>"), std::string::npos) << html;
  EXPECT_NE(html.find("<tr><td>steep</td><td>m</td>"), std::string::npos) << html;
}

}  // namespace
}  // namespace tribotrack::bench
