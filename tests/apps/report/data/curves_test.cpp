#include "apps/report/data/curves.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

constexpr double pi = std::numbers::pi;

/// Two runs that differ in dtau: one curve.
ReportData two_runs(const model::Scenario& at) {
  ReportData data;
  for (const double dtau : {1.0, 2.0}) {
    ReportRun run;
    run.phi_rad = 0;
    run.dtau_rad = dtau;
    run.measured["v_mm_s"].value = 1;
    run.fitted.fitted = at;
    data.runs.push_back(run);
  }
  return data;
}

model::Scenario scenario(double mu1, double mu2, double cycles) {
  model::Scenario s;
  s.drive.amplitude = s.drive.amplitude_y = 0.28e-3;
  s.drive.angular_frequency = 62.8;
  s.friction = {.nominal = mu1, .reduced = mu2, .phase = 0, .pulse_width = 1, .lag = 0.2};
  s.cycles = cycles;
  return s;
}

TEST(ReportCurves, AreTheModelAtEachPoint) {
  const model::Scenario first = scenario(0.1, 0.0125, 20);
  ReportData data = two_runs(first);
  add_curves(data);
  ASSERT_EQ(data.over_dtau.size(), 1u);
  const ReportGroup& curve = data.over_dtau.front();
  EXPECT_THAT(data.warnings, testing::IsEmpty());
  ASSERT_EQ(curve.curve_v_mm_s.size(), curve.curve_x_rad.size());
  for (std::size_t i = 0; i < curve.curve_x_rad.size(); i += 16) {
    model::Scenario s = first;
    s.friction.pulse_width = curve.curve_x_rad[i];
    const Eigen::Vector2d end = model::integrate(s).end().position;
    EXPECT_NEAR(curve.curve_v_mm_s[i], 1e3 * end.norm() / s.end_time(), 1e-6);
    EXPECT_NEAR(std::remainder(curve.curve_alpha_rad[i] - std::atan2(end.y(), end.x()), 2 * pi), 0, 1e-6);
  }
}

// Friction so low that a cycle forgets little of the one before: each point takes tens of thousands of steps.
TEST(ReportCurves, PointsThatTakeTooLongAreLeftOutAndSaid) {
  ReportData data = two_runs(scenario(1e-5, 1e-6, 5000));
  constexpr long few = 241 * 100;
  add_curves(data, few);
  ASSERT_EQ(data.over_dtau.size(), 1u);
  const ReportGroup& curve = data.over_dtau.front();
  const auto points = static_cast<long>(curve.curve_x_rad.size());
  for (const double v : curve.curve_v_mm_s) EXPECT_TRUE(std::isnan(v));
  for (const double alpha : curve.curve_alpha_rad) EXPECT_TRUE(std::isnan(alpha));
  EXPECT_THAT(data.warnings, testing::ElementsAre(testing::AllOf(
                                 testing::HasSubstr(fmt::format("lack {0} of {0} points", points)),
                                 testing::HasSubstr(fmt::format("more than {} steps", few / points)))));
}

}  // namespace

namespace {

using testing::ElementsAre;

ReportRun run(double phi, double dtau) {
  ReportRun r;
  r.phi_rad = phi;
  r.dtau_rad = dtau;
  r.measured["v_mm_s"].value = 1;
  return r;
}

TEST(ReportGroups, OneGroupPerSharedAngleOrderedByTheVariedOne) {
  const std::vector<ReportRun> runs = {run(pi, 1), run(0, 1), run(0, 2), run(pi / 2, 2), run(0, 3)};
  const auto over_phi = groups_over(Over::phi, runs);
  ASSERT_EQ(over_phi.size(), 2u);  // dtau = 3 has one phi only
  EXPECT_EQ(over_phi[0].shared_rad, 1);
  EXPECT_THAT(over_phi[0].runs, ElementsAre(1, 0));
  EXPECT_EQ(over_phi[1].shared_rad, 2);
  EXPECT_THAT(over_phi[1].runs, ElementsAre(2, 3));
  const auto over_dtau = groups_over(Over::dtau, runs);
  ASSERT_EQ(over_dtau.size(), 1u);
  EXPECT_EQ(over_dtau[0].shared_rad, 0);
  EXPECT_THAT(over_dtau[0].runs, ElementsAre(1, 2, 4));
}

TEST(ReportGroups, MeasuredAnglesThatScatterCountAsEqual) {
  const auto groups = groups_over(Over::phi, {run(0, 1.000), run(1, 1.004), run(2, 0.997)});
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_EQ(groups[0].runs.size(), 3u);
}

TEST(ReportGroups, PhiIsBroughtIntoOneTurn) {
  EXPECT_DOUBLE_EQ(angle_over(Over::phi, run(-pi / 2, 1)), 1.5 * pi);
  EXPECT_DOUBLE_EQ(angle_over(Over::phi, run(5 * pi, 1)), pi);
  EXPECT_NEAR(angle_over(Over::phi, run(2 * pi - 0.01, 1)), -0.01, 1e-15);
  const auto groups = groups_over(Over::dtau, {run(2 * pi - 0.005, 1), run(0.005, 2)});
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_THAT(groups_over(Over::phi, {run(-pi / 2, 1), run(pi, 1)}).at(0).runs, ElementsAre(1, 0));
}

TEST(ReportGroups, FailedRunsFreeSlidesAndRunsWithoutAVelocityAreLeftOut) {
  std::vector<ReportRun> runs = {run(0, 1), run(1, 1), run(2, 1), run(3, 1), run(4, 1)};
  runs[1].failure = "cannot be read";
  runs[2].free_slide = true;
  runs[3].measured.clear();
  EXPECT_THAT(groups_over(Over::phi, runs).at(0).runs, ElementsAre(0, 4));
}

TEST(ReportGroups, CurvesSpanAFullTurnOrTheRunsRange) {
  const std::vector<ReportRun> runs = {run(0, 1), run(pi, 1), run(0, 2)};
  const auto full = curve_angles(Over::phi, groups_over(Over::phi, runs)[0], runs, 5);
  EXPECT_THAT(full, ElementsAre(0, pi / 2, pi, 1.5 * pi, 2 * pi));
  const auto dtaus = curve_angles(Over::dtau, groups_over(Over::dtau, runs)[0], runs, 3);
  EXPECT_THAT(dtaus, ElementsAre(testing::DoubleEq(0.9), testing::DoubleEq(1.5), testing::DoubleEq(2.1)));
  const std::vector<ReportRun> narrow = {run(1, 1), run(2, 1)};
  const auto part = curve_angles(Over::phi, groups_over(Over::phi, narrow)[0], narrow, 2);
  EXPECT_THAT(part, ElementsAre(testing::DoubleEq(0.9), testing::DoubleEq(2.1)));
}

}  // namespace

namespace {

/// At rest where it was for 2 s.
ReportRun resting_run() {
  ReportRun run;
  run.name = "a";
  for (int frame = 0; frame <= 200; ++frame) {
    run.track.time_s.push_back(0.01 * frame);
    run.track.x_mm.push_back(3);
    run.track.y_mm.push_back(4);
  }
  return run;
}

TEST(ReportModelPath, BeginsWhereThePartWasFirstMeasured) {
  ReportRun run = resting_run();
  run.track.x_mm[0] = run.track.y_mm[0] = no_value;
  model::Scenario& scenario = run.fitted.fitted;
  scenario.cycles = 10;
  ASSERT_TRUE(add_model_path(run));
  ASSERT_EQ(run.model_x_mm.size(), run.track.time_s.size());
  EXPECT_TRUE(std::isnan(run.model_x_mm[0]));
  EXPECT_EQ(run.model_x_mm[1], 3);
  const model::Trajectory path = model::integrate(scenario);
  EXPECT_NEAR(run.model_x_mm[51], 3 + 1e3 * path.at(0.5).position.x(), 1e-9);
  EXPECT_NEAR(run.model_y_mm[51], 4 + 1e3 * path.at(0.5).position.y(), 1e-9);
  EXPECT_TRUE(std::isnan(run.model_x_mm[200]));  // 10 cycles end before 1.01 s
}

}  // namespace

}  // namespace tribotrack::apps
