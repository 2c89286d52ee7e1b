// The page and the table of claims, and the command that writes them.
#include "apps/paper/paper.h"

#include <gmock/gmock.h>

#include <sstream>

#include "apps/page/text.h"
#include "apps/paper/figures.h"
#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

const Paper& quick_paper() {
  static const Paper paper = [] {
    bench::ClaimOptions options;
    options.quick = true;
    return paper_of(options);
  }();
  return paper;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size()))
    ++found;
  return found;
}

TEST(PaperPage, EveryClaimStandsOnceWithItsVerdict) {
  const std::string page = page_of(quick_paper());
  for (const bench::PaperClaim& claim : quick_paper().claims) {
    const std::string name = sentence_html(claim.name), verdict = to_string(claim.verdict);
    EXPECT_EQ(count(page, "<q>" + sentence_html(claim.statement) + "</q>"), 1u) << claim.name;
    EXPECT_EQ(count(page, "<h3>" + name + ": " + verdict + "</h3>"), 1u) << claim.name;
    EXPECT_EQ(count(page, ">" + name + "</a></td>"), 1u) << claim.name << " in the table of the first screen";
    EXPECT_GE(count(page, "<p>" + sentence_html(claim.finding) + "</p>"), 1u) << claim.name;
  }
}

TEST(PaperPage, EveryFigureHasASectionWithItsClaims) {
  const std::string page = page_of(quick_paper());
  for (const Figure& figure : quick_paper().figures) {
    const std::size_t begin = page.find("<section id=\"" + figure.id + "\"");
    ASSERT_NE(begin, std::string::npos) << figure.id;
    const std::string section = page.substr(begin, page.find("</section>", begin) - begin);
    EXPECT_EQ(count(section, "id=\"plot-" + figure.id + "\""), 1u);
    std::size_t claims = 0;
    for (const bench::PaperClaim& claim : quick_paper().claims) claims += claim.figure == number_of(figure);
    EXPECT_GE(claims, 1u) << figure.id;
    EXPECT_EQ(count(section, "<h3>"), claims) << figure.id;
    EXPECT_EQ(count(section, "side only"), number_of(figure) >= 9 ? 1u : 0u) << figure.id;
  }
}

TEST(PaperPage, TheSameBytesTwice) {
  EXPECT_TRUE(page_of(quick_paper()) == page_of(quick_paper()));
}

TEST(PaperTable, HasARowForEachClaim) {
  std::istringstream csv(claims_csv(quick_paper()));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "figure,place,claim,verdict,quantity,conditions,value,unit,statement,finding");
  for (const bench::PaperClaim& claim : quick_paper().claims) {
    ASSERT_TRUE(std::getline(csv, line));
    EXPECT_THAT(line, HasSubstr("\"" + claim.name + "\"," + to_string(claim.verdict)));
    EXPECT_EQ(claim.statement.find('"'), std::string::npos);
  }
  EXPECT_FALSE(std::getline(csv, line));
}

class PaperCommand : public ProgramTest {};

TEST_F(PaperCommand, WritesThePageAndItsTables) {
  const Outcome outcome = run("paper -o out");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.err, HasSubstr("8 figures, 20 claims"));
  std::vector<std::string> names = {"paper.html", "claims.csv"};
  for (const Figure& figure : quick_paper().figures) {
    names.push_back(figure.id + ".csv");
    EXPECT_THAT(content_of(in_folder("out") / names.back()), testing::StartsWith("panel,series,"))
        << figure.id;
  }
  for (const std::string& name : names) {
    EXPECT_TRUE(std::filesystem::exists(in_folder("out") / name)) << name;
    EXPECT_TRUE(std::filesystem::exists(in_folder("out") / (name + ".meta.json"))) << name;
  }
  const auto files = std::filesystem::directory_iterator(in_folder("out"));
  EXPECT_EQ(static_cast<std::size_t>(std::distance(begin(files), end(files))), 2 * names.size());
}

TEST_F(PaperCommand, SaysWhatIsWrongBeforeTheWork) {
  expect_refused(run("paper"), 2, {"--output"});
  expect_refused(run("paper -o out --fast"), 2, {"--fast"});
  put(in_folder("file"), "");
  expect_refused(run("paper -o file"), 3, {"file"});
  std::filesystem::create_directories(in_folder("out/claims.csv"));
  expect_refused(run("paper -o out"), 3, {"claims.csv"});
}

}  // namespace
}  // namespace tribotrack::apps
