#include "apps/report/data/groups.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace tribotrack::apps {
namespace {

using testing::ElementsAre;

constexpr double pi = std::numbers::pi;

ReportRun run(double phi, double dtau) {
  ReportRun r;
  r.kind = "displacement";
  r.phi_rad = phi;
  r.dtau_rad = dtau;
  r.v_mm_s = 1;
  return r;
}

TEST(ReportGroups, OneGroupPerSharedAngleOrderedByTheVariedOne) {
  const std::vector<ReportRun> runs = {run(pi, 1), run(0, 1), run(0, 2), run(pi / 2, 2), run(0, 3)};
  const auto over_phi = group_over_phi(runs);
  ASSERT_EQ(over_phi.size(), 2u);  // dtau = 3 has one phi only
  EXPECT_EQ(over_phi[0].shared_rad, 1);
  EXPECT_THAT(over_phi[0].runs, ElementsAre(1, 0));
  EXPECT_EQ(over_phi[1].shared_rad, 2);
  EXPECT_THAT(over_phi[1].runs, ElementsAre(2, 3));
  const auto over_dtau = group_over_dtau(runs);
  ASSERT_EQ(over_dtau.size(), 1u);
  EXPECT_EQ(over_dtau[0].shared_rad, 0);
  EXPECT_THAT(over_dtau[0].runs, ElementsAre(1, 2, 4));
}

TEST(ReportGroups, RepeatedRunsAloneMakeNoFigure) {
  EXPECT_TRUE(group_over_phi({run(1, 1), run(1, 1), run(1.01, 1)}).empty());
  EXPECT_TRUE(group_over_dtau({run(1, 1), run(1, 1.01)}).empty());
  EXPECT_TRUE(group_over_phi({}).empty());
}

TEST(ReportGroups, MeasuredAnglesThatScatterCountAsEqual) {
  const auto groups = group_over_phi({run(0, 1.000), run(1, 1.004), run(2, 0.997)});
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].runs.size(), 3u);
}

TEST(ReportGroups, PhiIsBroughtIntoOneTurn) {
  EXPECT_DOUBLE_EQ(phi_in_one_turn(-pi / 2), 1.5 * pi);
  EXPECT_DOUBLE_EQ(phi_in_one_turn(5 * pi), pi);
  EXPECT_NEAR(phi_in_one_turn(2 * pi - 0.01), -0.01, 1e-15);
  const auto groups = group_over_dtau({run(2 * pi - 0.005, 1), run(0.005, 2)});
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_THAT(group_over_phi({run(-pi / 2, 1), run(pi, 1)}).at(0).runs, ElementsAre(1, 0));
}

TEST(ReportGroups, FailedRunsFreeSlidesAndRunsWithoutAVelocityAreLeftOut) {
  std::vector<ReportRun> runs = {run(0, 1), run(1, 1), run(2, 1), run(3, 1), run(4, 1)};
  runs[1].failure = "cannot be read";
  runs[2].kind = "free_slide";
  runs[3].v_mm_s = no_value;
  EXPECT_THAT(group_over_phi(runs).at(0).runs, ElementsAre(0, 4));
}

TEST(ReportGroups, CurvesSpanAFullTurnOrTheRunsRange) {
  const std::vector<ReportRun> runs = {run(0, 1), run(pi, 1), run(0, 2)};
  const auto full = curve_phis(group_over_phi(runs)[0], runs, 5);
  EXPECT_THAT(full, ElementsAre(0, pi / 2, pi, 1.5 * pi, 2 * pi));
  const auto dtaus = curve_dtaus(group_over_dtau(runs)[0], runs, 3);
  EXPECT_THAT(dtaus, ElementsAre(testing::DoubleEq(0.9), testing::DoubleEq(1.5), testing::DoubleEq(2.1)));
  const std::vector<ReportRun> narrow = {run(1, 1), run(2, 1)};
  const auto part = curve_phis(group_over_phi(narrow)[0], narrow, 2);
  EXPECT_THAT(part, ElementsAre(testing::DoubleEq(0.9), testing::DoubleEq(2.1)));
}

}  // namespace
}  // namespace tribotrack::apps
