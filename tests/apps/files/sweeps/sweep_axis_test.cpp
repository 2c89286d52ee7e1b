#include "apps/simulating/sweep.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "apps/program/errors.h"

namespace tribotrack::apps {
namespace {

using std::numbers::pi;

TEST(SweepAxis, RangesHaveBothEnds) {
  const SweepAxis axis("phi_rad=0:2pi:5");
  EXPECT_EQ(axis.name(), "phi_rad");
  ASSERT_EQ(axis.count(), 5u);
  EXPECT_EQ(axis.value(0), 0);
  EXPECT_DOUBLE_EQ(axis.value(1), pi / 2);
  EXPECT_DOUBLE_EQ(axis.value(4), 2 * pi);
  EXPECT_EQ(SweepAxis("mu1=0.1:0.2:1").value(0), 0.1);
}

TEST(SweepAxis, ListsAreTakenAsTheyStand) {
  const SweepAxis axis("amplitude_mm=0.32,0.28,0.31");
  ASSERT_EQ(axis.count(), 3u);
  EXPECT_EQ(axis.value(0), 0.32);
  EXPECT_EQ(axis.value(2), 0.31);
  EXPECT_DOUBLE_EQ(SweepAxis("dtau_rad=pi/6,pi").value(1), pi);
}

TEST(SweepAxis, WhatDoesNotReadIsRefused) {
  for (const char* text :
       {"", "phi_rad", "phi_rad=", "phi_rad=1", "phi_rad=0:1", "phi_rad=0,", "phi_rad=0,x", "phi_rad=,1",
        "phi_rad=0:1:0", "phi_rad=0:1:2.5", "phi_rad=0,90", "phi_rad=0:90:3"})
    EXPECT_THROW(SweepAxis{text}, UsageError) << text;
}

TEST(SweepAxis, ValuesInMemoryAreListed) {
  const SweepAxis axis("dtau_rad", {0.5, pi, 1});
  EXPECT_EQ(axis.name(), "dtau_rad");
  ASSERT_EQ(axis.count(), 3u);
  EXPECT_EQ(axis.value(1), pi);
  EXPECT_THROW(SweepAxis("dtau_rad", {}), UsageError);
  EXPECT_THROW(SweepAxis("dtau_rad", {90}), UsageError);
  EXPECT_THROW(SweepAxis("mu1", {std::nan("")}), UsageError);
}

TEST(Sweep, TheLastAxisRunsFastest) {
  ScenarioFile file;
  file.mu1_over_mu2 = 8;
  const Sweep sweep(file, sweep_axes({"mu1=0.08,0.12", "dtau_rad=0:1:3"}));
  ASSERT_EQ(sweep.count(), 6u);
  EXPECT_EQ(sweep.value(4, 0), 0.12);
  EXPECT_EQ(sweep.value(4, 1), 0.5);
  const model::Scenario scenario = sweep.scenario(4);
  EXPECT_EQ(scenario.friction.nominal, 0.12);
  EXPECT_EQ(scenario.friction.reduced, 0.12 / 8);
  EXPECT_EQ(scenario.friction.pulse_width, 0.5);
}

}  // namespace
}  // namespace tribotrack::apps
