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
ReportData two_runs() {
  ReportData data;
  for (const double dtau : {1.0, 2.0}) {
    ReportRun run;
    run.kind = "displacement";
    run.phi_rad = 0;
    run.dtau_rad = dtau;
    run.v_mm_s = 1;
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
  ReportData data = two_runs();
  const model::Scenario first = scenario(0.1, 0.0125, 20);
  add_curves({first, first}, data);
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
  ReportData data = two_runs();
  const model::Scenario first = scenario(1e-5, 1e-6, 5000);
  constexpr long few = 241 * 100;
  add_curves({first, first}, data, few);
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
}  // namespace tribotrack::apps
