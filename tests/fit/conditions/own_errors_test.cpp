#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "fit/conditions.h"

namespace tribotrack::fit {
namespace {

using model::Parameter;

/// A marker and a lamp: phase to 1e-3 in the middle of 2 s, w to 1e-3. Commanded otherwise.
RunEvidence measured() {
  RunEvidence run;
  run.phi.value = 1;
  run.dtau.value = 1.1;
  run.seen.emplace();
  run.seen->angular_frequency = {60, 1e-3};
  run.seen->phase_at_zero = {0.5, std::hypot(1e-3, 1e-3)};
  run.seen->phase_at_middle = {60.5, 1e-3};
  run.seen->middle_time = 1;
  run.start = 0.5;
  run.start_assumed = false;
  run.gate.emplace();
  run.gate->phi = {1.2, std::hypot(2e-3, 1e-3)};
  run.gate->dtau = {1, std::hypot(2e-3, 3e-3)};
  run.gate->covariance = -4e-6;
  run.gate_by_camera = true;
  return run;
}

double entry(const OwnErrors& own, Parameter a, Parameter b) {
  const auto at = [&](Parameter p) { return std::ranges::find(own.parameters, p) - own.parameters.begin(); };
  return own.covariance(at(a), at(b));
}

TEST(OwnErrors, TheMarkersPhaseIsInPhiAndInTheStart) {
  const Timing timing = settle_timing(measured());
  EXPECT_EQ(timing.phi, 1.2);
  EXPECT_EQ(timing.dtau, 1);
  EXPECT_EQ(timing.start_phase, 0.5);
  EXPECT_NEAR(entry(timing.own, Parameter::phi, Parameter::phi), 5e-6, 1e-18);
  EXPECT_NEAR(entry(timing.own, Parameter::phi, Parameter::dtau), -4e-6, 1e-18);
  EXPECT_NEAR(entry(timing.own, Parameter::start_phase, Parameter::start_phase), 2e-6, 1e-18);
  EXPECT_NEAR(entry(timing.own, Parameter::phi, Parameter::start_phase), 1e-6, 1e-18);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(timing.own.covariance);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), 0);
}

TEST(OwnErrors, WhatACoderDoesToAllRunsIsNotOwn) {
  RunEvidence run = measured();
  run.seen->phase_at_middle.sd = std::hypot(1e-3, 0.02);
  run.gate->phi.sd = std::hypot(2e-3, run.seen->phase_at_middle.sd);
  run.coder_delay = 0.02;
  const OwnErrors own = settle_timing(run).own;
  EXPECT_NEAR(entry(own, Parameter::start_phase, Parameter::start_phase), 2e-6, 1e-15);
  EXPECT_NEAR(entry(own, Parameter::phi, Parameter::phi), 5e-6, 1e-15);
}

TEST(OwnErrors, ACommandedWidthWithAnSdIsTakenIn) {
  RunEvidence run = measured();
  run.dtau.sd = std::sqrt(13e-6);  // as good as the lamp
  const Timing timing = settle_timing(run);
  EXPECT_NEAR(timing.dtau, 1.05, 1e-12);
  EXPECT_NEAR(timing.phi, 1.2 - 4.0 / 26 * 0.1, 1e-12);  // the opening goes earlier as the pulse is longer
  EXPECT_NEAR(entry(timing.own, Parameter::dtau, Parameter::dtau), 6.5e-6, 1e-15);
}

TEST(OwnErrors, ACommandedPhiIsNoPhiOfTheCamera) {
  RunEvidence run = measured();
  run.phi.sd = 1e-4;
  EXPECT_EQ(settle_timing(run).phi, 1.2);
  run.gate_by_camera = false;
  EXPECT_NEAR(settle_timing(run).phi, 1.0, 1e-3);
}

TEST(OwnErrors, OfARunMeasuredElsewhereAreThoseGiven) {
  RunEvidence run;
  run.phi = {1, 0.01};
  run.dtau = {2, 0};
  run.start_phase = Estimate{0.3, 0.02};
  const Timing timing = settle_timing(run);
  EXPECT_EQ(timing.start_phase, 0.3);
  EXPECT_EQ(timing.own.parameters, (std::vector{Parameter::phi, Parameter::start_phase}));
  EXPECT_NEAR(timing.own.sd(Parameter::phi), 0.01, 1e-15);
  EXPECT_NEAR(timing.own.sd(Parameter::start_phase), 0.02, 1e-15);
}

}  // namespace
}  // namespace tribotrack::fit
