#include "apps/report/tables/tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "apps/chromium.h"
#include "apps/report_sample.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

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

TEST(RunsCsv, WhatWouldBreakARowIsQuoted) {
  ReportData data = sample::campaign();
  data.runs[14].failure = "ends, \"early\"";
  EXPECT_THAT(runs_csv(data), HasSubstr(",\"ends, \"\"early\"\"\"\n"));
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

TEST(ReportText, IsOneBlockToPaste) {
  const std::string text = report_text(sample::campaign());
  EXPECT_THAT(text, HasSubstr("Silver-coated disc, 6 mm, on polished duralumin\n"));
  EXPECT_THAT(text, HasSubstr("0.10012(31)"));
  EXPECT_THAT(text, HasSubstr("95 %: 0.09952 to 0.10073"));
  EXPECT_THAT(text, HasSubstr("correlation of mu2 and mu1: 0.42"));
  EXPECT_THAT(text, HasSubstr("chi2 = 26.4 with 27 degrees of freedom"));
  EXPECT_THAT(text, HasSubstr("tracking noise"));
  EXPECT_THAT(text, HasSubstr("Computed with tribotrack 0.1.0."));
  EXPECT_EQ(test::occurrences(text, "<"), 0u) << "no HTML in it";
}

TEST(ReportText, WithoutAFitItSpeaksOfMeasurements) {
  ReportData data = sample::campaign();
  data.fit.parameters.clear();
  EXPECT_THAT(report_text(data), HasSubstr("Measurements only"));
  EXPECT_EQ(test::occurrences(report_text(data), "parameters: value"), 0u);
}

}  // namespace
}  // namespace tribotrack::apps
