#include "apps/campaign/own_errors.h"

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace tribotrack::apps {
namespace {

using model::Parameter;
using ::testing::HasSubstr;

/// A marker and a lamp: phase to 1e-3 in the middle of 2 s, w to 1e-3.
RunMeasurement measured() {
  RunMeasurement m;
  fit::PlatformMotion platform;
  platform.angular_frequency = {60, 1e-3};
  platform.phase_at_zero = {0.5, std::hypot(1e-3, 1e-3)};
  platform.phase_at_middle = {60.5, 1e-3};
  platform.middle_time = 1;
  m.platform = platform;
  m.phase_at_start = 0.5;
  m.phase_source = "marker";
  fit::GateTiming gate;
  gate.phi = {1.2, std::hypot(2e-3, 1e-3)};
  gate.dtau = {1, std::hypot(2e-3, 3e-3)};
  gate.covariance = -4e-6;
  gate.source = "lamp";
  m.gate = gate;
  m.gate_reference = "camera";
  return m;
}

double entry(const fit::OwnErrors& own, Parameter a, Parameter b) {
  const auto at = [&](Parameter p) {
    return std::find(own.parameters.begin(), own.parameters.end(), p) - own.parameters.begin();
  };
  return own.covariance(at(a), at(b));
}

CampaignRun commanded() {
  CampaignRun run;
  run.name = "r";
  run.phi = 1;
  run.dtau = 1.1;
  return run;
}

TEST(OwnErrors, TheMarkersPhaseIsInPhiAndInTheStart) {
  RunMeasurement m = measured();
  model::Scenario s;
  const fit::OwnErrors own = settle_timing(commanded(), m, s);
  EXPECT_EQ(s.friction.phase, 1.2);
  EXPECT_EQ(s.friction.pulse_width, 1);
  EXPECT_EQ(s.start_phase, 0.5);
  EXPECT_NEAR(entry(own, Parameter::phi, Parameter::phi), 5e-6, 1e-18);
  EXPECT_NEAR(entry(own, Parameter::phi, Parameter::dtau), -4e-6, 1e-18);
  EXPECT_NEAR(entry(own, Parameter::start_phase, Parameter::start_phase), 2e-6, 1e-18);
  EXPECT_NEAR(entry(own, Parameter::phi, Parameter::start_phase), 1e-6, 1e-18);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(own.covariance);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), 0);
}

TEST(OwnErrors, WhatACoderDoesToAllRunsIsNotOwn) {
  RunMeasurement m = measured();
  m.platform->phase_at_middle.sd = std::hypot(1e-3, 0.02);
  m.gate->phi.sd = std::hypot(2e-3, m.platform->phase_at_middle.sd);
  m.coded = CodedMotion{.coder = "x264", .delay = 0.02};
  model::Scenario s;
  const fit::OwnErrors own = settle_timing(commanded(), m, s);
  EXPECT_NEAR(entry(own, Parameter::start_phase, Parameter::start_phase), 2e-6, 1e-15);
  EXPECT_NEAR(entry(own, Parameter::phi, Parameter::phi), 5e-6, 1e-15);
}

TEST(OwnErrors, ACommandedWidthWithAnSdIsTakenIn) {
  RunMeasurement m = measured();
  model::Scenario s;
  CampaignRun run = commanded();
  run.dtau_sd = std::sqrt(13e-6);  // as good as the lamp
  const fit::OwnErrors own = settle_timing(run, m, s);
  EXPECT_NEAR(s.friction.pulse_width, 1.05, 1e-12);
  EXPECT_NEAR(s.friction.phase, 1.2 - 4.0 / 26 * 0.1,
              1e-12);  // the opening goes earlier as the pulse is longer
  EXPECT_NEAR(entry(own, Parameter::dtau, Parameter::dtau), 6.5e-6, 1e-15);
}

TEST(OwnErrors, ACommandedPhiIsNoPhiOfTheCamera) {
  RunMeasurement m = measured();
  model::Scenario s;
  CampaignRun run = commanded();
  run.phi_sd = 1e-4;
  settle_timing(run, m, s);
  EXPECT_EQ(s.friction.phase, 1.2);
  ASSERT_EQ(m.warnings.size(), 1u);
  EXPECT_THAT(m.warnings[0], HasSubstr("r: phi_rad_sd is not used"));
  m = measured();
  m.gate_reference = "sensor";
  settle_timing(run, m, s);
  EXPECT_NEAR(s.friction.phase, 1.0, 1e-3);
}

TEST(OwnErrors, WithoutTakesRowsAndColumns) {
  fit::OwnErrors own;
  add_error(own, Parameter::phi, 4);
  add_error(own, Parameter::dtau, 9);
  add_error(own, Parameter::start_phase, 16);
  add_error(own, Parameter::phi, Parameter::start_phase, 5);
  const fit::OwnErrors rest = without(own, {Parameter::dtau});
  EXPECT_EQ(rest.parameters, (std::vector<Parameter>{Parameter::phi, Parameter::start_phase}));
  EXPECT_EQ(rest.covariance, (Eigen::Matrix2d() << 4, 5, 5, 16).finished());
  EXPECT_EQ(sd_of(rest, Parameter::dtau), 0);
  EXPECT_EQ(sd_of(rest, Parameter::start_phase), 4);
}

}  // namespace
}  // namespace tribotrack::apps
