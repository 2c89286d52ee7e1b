#include "apps/report/tables/tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "apps/program.h"
#include "apps/report_sample.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) list.push_back(line);
  return list;
}

std::string cell(const std::string& csv, std::size_t row, const std::string& column) {
  const auto cells = [](const std::string& line) {
    std::vector<std::string> list;
    std::istringstream stream(line + ",");
    for (std::string one; std::getline(stream, one, ',');) list.push_back(one);
    return list;
  };
  const std::vector<std::string> head = cells(lines(csv)[0]), values = cells(lines(csv)[row]);
  EXPECT_EQ(head.size(), values.size()) << "row " << row;
  const auto at = std::ranges::find(head, column) - head.begin();
  return values.at(static_cast<std::size_t>(at));
}

TEST(RunsCsv, HasARowForEachRunWithAllDigits) {
  ReportData data = sample::campaign();
  data.runs[0].measured["alpha_rad"].value = 1.0 / 3;
  const std::string csv = runs_csv(data);
  EXPECT_EQ(lines(csv).size(), 1 + data.runs.size());
  EXPECT_EQ(cell(csv, 1, "alpha_rad"), "0.3333333333333333");
  EXPECT_EQ(cell(csv, 1, "dx_residual_sd"), exact(data.runs[0].fitted.residuals[0].standardised));
  EXPECT_EQ(cell(csv, 8, "frames_lost"), "3");
  EXPECT_EQ(cell(csv, 8, "frames_repeated"), "0");
  EXPECT_EQ(cell(csv, 14, "frame_rate_hz"), "") << "measured elsewhere";
}

TEST(ParametersCsv, HoldsIntervalsAndCorrelationsAndLeavesOpenEndsEmpty) {
  ReportData data = sample::campaign();
  data.fit.parameters[1].ci95.high = std::numeric_limits<double>::infinity();
  const std::string csv = parameters_csv(data);
  EXPECT_EQ(cell(csv, 1, "estimate"), "0.100123");
  EXPECT_EQ(cell(csv, 2, "ci95_high"), "");
  EXPECT_EQ(cell(csv, 2, "correlation_with_mu1"), "0.42");
  EXPECT_EQ(cell(csv, 3, "profile_ci95_low"), "0.2899");
}

ReportData all_well() {
  ReportData data = sample::campaign();
  data.warnings.clear();
  std::erase_if(data.runs, [](const ReportRun& run) { return !run.failure.empty(); });
  return data;
}

// The fit decides and gives the reasons; the page adds runs that failed.
TEST(ReportVerdict, IsThatOfTheFit) {
  ReportData data = all_well();
  data.fit.verdict = fit::Use::care;
  data.fit.verdict_reasons = {"the values hold under a tilt", "one run <a> contradicts the others"};
  EXPECT_STREQ(verdict_of(data).style, "care");
  EXPECT_EQ(verdict_of(data).heading,
            "Use with care: the values hold under a tilt; one run <a> contradicts the others");
  data.runs[0].failure = "gone";
  EXPECT_THAT(verdict_of(data).heading, HasSubstr("others; one run failed"));
  data.fit.verdict = fit::Use::do_not_use;
  EXPECT_EQ(verdict_of(data).heading, "Do not use these values");
  EXPECT_THAT(verdict_of(data).paragraph, StartsWith("The values hold under a tilt; one run"));
  data = all_well();
  data.runs[0].failure = "gone";
  EXPECT_EQ(verdict_of(data).heading, "Use with care: one run failed");
}

}  // namespace
}  // namespace tribotrack::apps
