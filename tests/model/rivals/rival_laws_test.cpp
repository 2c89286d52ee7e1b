// Rival friction laws: their limits, and closed forms where there are any.
#include "model/rival_laws.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

Eigen::Matrix2Xd rival_displacements(const Scenario& scenario, std::span<const RivalLaw> laws,
                                     double tolerance) {
  return rival_positions(scenario, {scenario.end_time()}, laws, tolerance);
}

Eigen::Vector2d rival_displacement(const Scenario& scenario, const RivalLaw& law, double tolerance = 1e-9) {
  return rival_displacements(scenario, std::span(&law, 1), tolerance);
}

// Laws that stop and start the part at other times, side by side, are each as alone.
TEST(RivalLaws, SideBySideEachIsAsAlone) {
  const std::vector<RivalLaw> laws{{},
                                   {.stribeck = 0.3},
                                   {.viscous = 2},
                                   {.rise = 2e-3},
                                   {.mu2_speed = 0.5},
                                   {.static_friction = 0.04},
                                   {.stribeck = -0.2, .viscous = -1, .rise = 5e-3}};
  for (const double mu1 : {0.06, 0.1, 0.1124, 0.15}) {
    Scenario scenario;
    scenario.friction = {mu1, mu1 / 6, 0.4, 1.3, 0.2};
    scenario.drive.tilt_x = 0.003;
    scenario.cycles = 12;
    const Eigen::Matrix2Xd together = rival_displacements(scenario, laws, 1e-9);
    for (std::size_t i = 0; i < laws.size(); ++i) {
      const Eigen::Vector2d alone = rival_displacement(scenario, laws[i], 1e-10);
      EXPECT_LT((together.col(i) - alone).norm(), 1e-7 * alone.norm() + 1e-12)
          << "mu1 = " << mu1 << ", law " << i;
    }
  }
  EXPECT_THROW(rival_displacements(Scenario{}, {}, 1e-9), InvalidParameter);
}

// Wherever a run is looked at, it is where a run that ends there ends; whole turns that repeat are passed
// over.
TEST(RivalLaws, PositionsOnTheWayAreTheEndsOfShorterRuns) {
  const std::vector<RivalLaw> laws{{}, {.stribeck = 0.3}, {.viscous = 2, .rise = 2e-3}};
  for (const double mu1 : {0.06, 0.1, 0.15}) {
    Scenario scenario;
    scenario.friction = {mu1, mu1 / 6, 0.4, 1.3, 0.2};
    scenario.cycles = 30;
    const std::vector<double> times{0, 1e-4, 0.013, 0.013, 0.1, 1.7, scenario.end_time()};
    const Eigen::MatrixXd seen = rival_positions(scenario, times, laws, 1e-10);
    Eigen::Matrix2Xd paper;
    integrate(scenario).positions_at(times, 0, paper, nullptr);
    EXPECT_LT((seen.col(0) - paper.reshaped()).norm(), 1e-7 * paper.norm()) << mu1;
    for (std::size_t k = 1; k < times.size(); ++k) {
      Scenario until = scenario;
      until.duration = times[k];
      const Eigen::Matrix2Xd end = rival_displacements(until, laws, 1e-10);
      EXPECT_LT((seen.middleRows(2 * static_cast<Eigen::Index>(k), 2) - end).norm(),
                1e-6 * end.norm() + 1e-12)
          << mu1 << ", " << times[k];
    }
  }
  EXPECT_THROW(rival_positions(Scenario{}, {0.2, 0.1}, laws), InvalidParameter);
  EXPECT_THROW(rival_positions(Scenario{}, {}, laws), InvalidParameter);
}

// Friction that all but holds the part lets it creep: stiff, and no reason for more steps. A search
// may go to phases that count no turns any more.
TEST(RivalLaws, PartsThatCreepAndPhasesFarAwayComeToAnEnd) {
  for (const double mu1 : {0.1118, 0.1124, 0.1126}) {  // A w^2 / g = 0.1126
    Scenario scenario;
    scenario.friction = {mu1, 0.01, 0.4, 1.3, 0.2};
    scenario.cycles = 20;
    const Eigen::Vector2d exact = integrate(scenario).end().position;
    EXPECT_LT((rival_displacement(scenario, {}, 1e-8) - exact).norm(), 1e-6 * exact.norm()) << mu1;
  }
  Scenario far;
  far.friction = {0.1, 0.01, 0.4, 1.3, 1e20};
  EXPECT_TRUE(rival_displacement(far, {}).allFinite());
  far.friction.lag = 0.2;
  far.start_phase = 1e37;
  EXPECT_TRUE(rival_displacement(far, {}).allFinite());
}

TEST(RivalLaws, FrictionThatPushesIsRefused) {
  Scenario scenario;  // A w = 0.0176 m/s
  scenario.friction = {0.1, 0.0125, 0.4, 1.3, 0.2};
  EXPECT_NO_THROW(rival_displacement(scenario, {.viscous = -6}));  // of 7.0 that leave nothing of mu2 g
  EXPECT_THROW(rival_displacement(scenario, {.viscous = -8}), InvalidParameter);
  EXPECT_THROW(rival_displacement(scenario, {.mu2_speed = -1.1}), InvalidParameter);
}

// A short rise about the edge changes nothing to first order.
TEST(RivalLaws, AShortRiseIsOfSecondOrder) {
  Scenario scenario;
  scenario.friction = {0.1, 0.0125, 0.4, 1.3, 0.2};
  scenario.cycles = 5;
  const Eigen::Vector2d sharp = rival_displacement(scenario, {}, 1e-11);
  double error[2];
  for (int k = 0; k < 2; ++k)
    error[k] = (rival_displacement(scenario, {.rise = 4e-4 / (1 + k)}, 1e-11) - sharp).norm();
  EXPECT_NEAR(error[0] / error[1], 4, 0.2);
}

// mu as a trapezoid, by steps of the midpoint rule so small that no care is needed; the part never sticks
// here.
Eigen::Vector2d with_trapezoid(const Scenario& s, double rise) {
  const double w = s.drive.angular_frequency, amplitude = s.drive.amplitude, turn = 2 * M_PI;
  const auto mu = [&](double t) {
    double into = w * (t + 0.5 * rise) - s.friction.phase - s.friction.lag;
    into -= turn * std::floor(into / turn);
    const bool reduced = into < s.friction.pulse_width;
    const double since = (into - (reduced ? 0 : s.friction.pulse_width)) / w;
    const double from = reduced ? s.friction.nominal : s.friction.reduced;
    const double to = reduced ? s.friction.reduced : s.friction.nominal;
    return since < rise ? from + (to - from) * since / rise : to;
  };
  // Relative to the platform, eqs. (1) and (5): xi = A cos wt, eta = A cos(wt + epsilon).
  const auto slope = [&](double t, const Eigen::Vector2d& u) -> Eigen::Vector2d {
    const Eigen::Vector2d drive =
        amplitude * w * w * Eigen::Vector2d(std::cos(w * t), std::cos(w * t + s.drive.phase_shift));
    return u.norm() > 0 ? Eigen::Vector2d(drive - mu(t) * s.drive.gravity * u / u.norm()) : drive;
  };
  constexpr int kSteps = 400'000;
  const double h = s.end_time() / kSteps;
  Eigen::Vector2d x = Eigen::Vector2d::Zero(), u = Eigen::Vector2d::Zero();
  for (int k = 0; k < kSteps; ++k) {
    const double t = k * h;
    const Eigen::Vector2d middle = u + 0.5 * h * slope(t, u);
    x += h * middle;
    u += h * slope(t + 0.5 * h, middle);
  }
  return x;
}

TEST(RivalLaws, ALongRiseIsATrapezoid) {
  Scenario scenario;
  scenario.friction = {0.06, 0.0125, 0.4, 2.0, 0.2};
  scenario.cycles = 2;
  constexpr double kRise = 0.02;
  const Eigen::Vector2d trapezoid = with_trapezoid(scenario, kRise);
  EXPECT_LT((rival_displacement(scenario, {.rise = kRise}) - trapezoid).norm(), 1e-5 * trapezoid.norm());
  EXPECT_GT((rival_displacement(scenario, {}) - trapezoid).norm(), 1e-3 * trapezoid.norm())
      << "sharp edges do as well: this test shows nothing of the rise";
}

TEST(RivalLaws, WhatIsOutOfRangeIsRefused) {
  Scenario scenario;
  scenario.friction.pulse_width = 1;
  EXPECT_THROW(rival_displacement(scenario, {.stribeck = -1}), InvalidParameter);
  EXPECT_THROW(rival_displacement(scenario, {.stribeck = 0.1, .fading = -1}), InvalidParameter);
  EXPECT_THROW(rival_displacement(scenario, {.rise = 1}), InvalidParameter);
  scenario.start = Start::steady;
  EXPECT_THROW(rival_displacement(scenario, {}), InvalidParameter);
}

// A slide stops after the integral of v dv / m(v), m what friction takes; viscous parts of law and scenario
// add up.
TEST(RivalLaws, ASlideStopsWhereItsEnergyIsSpent) {
  for (const double viscous : {0.0, 0.8})
    for (const double fading : {0.0, 0.05, 0.3}) {
      Scenario slide;
      slide.drive.amplitude = slide.drive.amplitude_y = 0;
      slide.friction = {0.2, 0, 0, 0, 0};
      slide.initial_velocity = {0.3, 0.4};
      slide.viscous = 0.25 * viscous;
      slide.duration = 2;
      const double scale = fading > 0 ? fading : 0.5 / 4;
      constexpr int kSteps = 20'000;
      double way = 0;
      for (int i = 0; i < kSteps; ++i) {
        const double v = (i + 0.5) * 0.5 / kSteps;
        way += v * (0.5 / kSteps) /
               (0.2 * slide.drive.gravity * (1 + 0.4 * std::exp(-v * v / (scale * scale))) + viscous * v);
      }
      const Eigen::Vector2d end =
          rival_displacement(slide, {.stribeck = 0.4, .fading = fading, .viscous = 0.75 * viscous});
      EXPECT_LT((end - way * Eigen::Vector2d(0.6, 0.8)).norm(), 1e-7 * way) << viscous << " " << fading;
    }
}

// A part that is held at rest by more than mu1 starts later, and only there; mu2 matters in the gate alone.
TEST(RivalLaws, StaticFrictionHoldsAndMu2RisesInItsGate) {
  Scenario sliding;  // never at rest but at the start, where the drive exceeds 1.1 mu1 g
  sliding.friction = {0.06, 0.0125, 0.4, 1.3, 0.2};
  sliding.cycles = 3;
  const Eigen::Vector2d moved = rival_displacement(sliding, {});
  EXPECT_LT((rival_displacement(sliding, {.static_friction = 0.1}) - moved).norm(), 1e-9 * moved.norm());
  Scenario held = sliding;
  held.friction.nominal = 0.109;  // A w^2 / g = 0.1126
  held.friction.pulse_width = 0;
  EXPECT_GT(rival_displacement(held, {}).norm(), 0);
  EXPECT_EQ(rival_displacement(held, {.static_friction = 0.1}).norm(), 0);
  Scenario wide = sliding;
  wide.friction.reduced = 0.0125 * 1.1;
  // Between mu2 and what it is at twice the platform's speed, which no part exceeds here.
  const double change = (rival_displacement(sliding, {.mu2_speed = 0.1}) - moved).norm();
  EXPECT_GT(change, 0.05 * (rival_displacement(wide, {}) - moved).norm());
  EXPECT_LT(change, 2 * (rival_displacement(wide, {}) - moved).norm());
  sliding.friction.pulse_width = 0;
  EXPECT_EQ(rival_displacement(sliding, {.mu2_speed = 0.1}), rival_displacement(sliding, {}));
}

// u' = -m - c u on a platform that rests: u = (u0 + m/c) e^{-ct} - m/c.
TEST(RivalLaws, SlidesOnAPlatformAtRest) {
  Scenario scenario;
  scenario.drive.amplitude = scenario.drive.amplitude_y = 0;
  scenario.friction = {0.1, 0.1, 0, 0, 0};
  scenario.initial_velocity = {0.3, 0.4};
  const double m = 0.1 * 9.81, c = 2, u0 = 0.5, stop = std::log(1 + c * u0 / m) / c;
  for (const double time : {0.1, 0.25, 0.6}) {
    scenario.duration = time;
    const double t = std::min(time, stop);
    const double way = (u0 + m / c) / c * (1 - std::exp(-c * t)) - m / c * t;
    EXPECT_NEAR(rival_displacement(scenario, {.viscous = c}, 1e-10).norm(), way, 1e-9) << time;
  }
}

}  // namespace
}  // namespace tribotrack::model
