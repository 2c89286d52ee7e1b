// A lamp and a command both tell phi and dtau: that which knows better counts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <tuple>

#include "apps/campaign/conditions.h"
#include "apps/campaign/shared_conditions.h"

namespace tribotrack::apps {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Matches;

constexpr double kW = 62.8, kA = 0.28e-3, kDtau = std::numbers::pi / 3;

/// A mark and a lamp, filmed with so many frames to a turn and 0.02 ms of exposure.
Track film(double phi, double frames_a_turn) {
  Track track;
  track.mm_per_px = 0.1;
  track.exposure_s = track.table.exposure = track.lamp.exposure.emplace(2e-5);
  track.table.platform_frame = true;
  std::mt19937 random(3);
  std::normal_distribution<> noise(0, 1e-6);
  for (int k = 0; k < 20 * frames_a_turn + 4; ++k) {
    const double phase = 2 * std::numbers::pi * k / frames_a_turn, t = phase / kW;
    track.table.frame.push_back(k);
    track.table.time.push_back(t);
    track.table.position.emplace_back(4e-3 * t + noise(random), noise(random));
    track.table.covariance.push_back(1e-12 * Eigen::Matrix2d::Identity());
    track.table.marker.emplace_back(kA * std::cos(phase) + noise(random),
                                    -kA * std::sin(phase) + noise(random));
    track.table.marker_sigma.push_back(1e-6);
    const double since = std::remainder(phase - phi - kDtau / 2, 2 * std::numbers::pi);
    track.lamp.time.push_back(t);
    track.lamp.level.push_back((std::abs(since) < kDtau / 2 ? 220 : 20) + 1e6 * noise(random));
  }
  return track;
}

Run run_of(double phi, double frames_a_turn) {
  Run run;
  run.given.name = "run";
  run.given.phi = phi;
  run.given.dtau = kDtau;
  run.given.cycles = 20;
  run.track = film(phi, frames_a_turn);
  return run;
}

Campaign campaign() {
  Campaign all;
  all.camera.gate_px = vision::Circle{10, 10, 4};
  return all;
}

constexpr double kAlike = 24.01, kSpread = 24.618;  ///< frames a turn: at the same phases every turn, at all

TEST(LampOrCommand, ALampThatKnowsBetterCounts) {
  apps::Run run = run_of(0.6, kSpread);
  measure_again(campaign(), run);
  ASSERT_TRUE(run.gate);
  EXPECT_EQ(run.gate_reference, "camera");
  EXPECT_LT(run.gate->phi.sd, 0.01);
  EXPECT_EQ(run.scenario.friction.phase, run.gate->phi.value);
}

TEST(LampOrCommand, ACommandStaysBesideFramesThatLeaveTheEdgesOpen) {
  for (const double sd : {0.0, 5e-3}) {  // of which nobody says how well it is known, and known to so much
    apps::Run run = run_of(0.6, kAlike);
    if (sd > 0) run.given.phi_sd = run.given.dtau_sd = sd;
    measure_again(campaign(), run);
    ASSERT_TRUE(run.measurement->gate) << "what the lamp shows is told all the same";
    EXPECT_GT(run.measurement->gate->phi.sd, 0.03);
    EXPECT_FALSE(run.gate);
    EXPECT_EQ(run.scenario.friction.phase, 0.6);
    EXPECT_EQ(run.scenario.friction.pulse_width, kDtau);
    EXPECT_NEAR(run.own.sd(model::Parameter::phi), sd, 1e-12);
    EXPECT_NEAR(run.own.sd(model::Parameter::dtau), sd, 1e-12);
    EXPECT_THAT(run.measurement->warnings, Contains(HasSubstr("taken as commanded")));
  }
}

TEST(LampOrCommand, WhereTheyContradictItIsSaid) {
  for (const auto& [frames, commanded, said] :
       {std::tuple(kSpread, 0.6, false), {kSpread, 0.7, true}, {kAlike, 0.6, false}, {kAlike, 1.2, true}}) {
    apps::Run run = run_of(0.6, frames);
    run.given.phi = commanded;
    measure_again(campaign(), run);
    EXPECT_EQ(Matches(Contains(HasSubstr("shows phi =")))(run.measurement->warnings), said)
        << frames << " " << commanded;
    EXPECT_EQ(run.measurement->phi_contradicts, said);
  }
}

TEST(LampOrCommand, ACommandKnownWorseYieldsToThem) {
  apps::Run run = run_of(0.6, kAlike);
  run.given.phi_sd = run.given.dtau_sd = 0.3;
  measure_again(campaign(), run);
  ASSERT_TRUE(run.gate);
  EXPECT_EQ(run.gate_reference, "camera");
  EXPECT_NEAR(run.own.sd(model::Parameter::phi), run.gate->phi.sd, 0.2 * run.gate->phi.sd);
}

}  // namespace
}  // namespace tribotrack::apps
