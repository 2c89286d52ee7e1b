// The integrator against two closed forms: a mass on a shaken plane (code_aster SDND104), a part on a belt.
#include "model/shaken_plane.h"

#include <gtest/gtest.h>

#include <random>

#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

struct Shaken {
  Shaken(double given_eta, double given_angle, double cycles = 20)
      : eta(given_eta), angle(given_angle), scenario(shaken_plane_scenario(eta, angle)) {
    scenario.cycles = cycles;
  }
  double unit() const { return std::hypot(scenario.drive.amplitude, scenario.drive.amplitude_y); }
  double time(ShakenPlane::Real tau) const {
    return static_cast<double>(tau / scenario.drive.angular_frequency);
  }
  Vector2d line() const { return {std::cos(angle), std::sin(angle)}; }

  double eta, angle;
  Scenario scenario;
};

TEST(ShakenPlane, FollowsTheClosedFormInEveryDirection) {
  std::mt19937 random(104);
  for (const double eta : {1e-9, 1e-6, 1e-3, 0.02, 0.05, 0.1, 0.2, 0.5, 0.53, 0.54, 0.6, 0.8, 0.95, 0.999})
    for (int k = 0; k < 10; ++k) {
      const Shaken shaken(eta, std::uniform_real_distribution<double>(0, 2 * pi)(random));
      SCOPED_TRACE("eta " + std::to_string(eta) + " angle " + std::to_string(shaken.angle));
      const ShakenPlane exact(eta, 40 * ShakenPlane::kPi);
      const Trajectory run = integrate(shaken.scenario);
      const double speed = shaken.unit() * shaken.scenario.drive.angular_frequency;
      for (int i = 0; i <= 100; ++i) {
        const double t = run.end_time() * i / 100;
        const ShakenPlane::Real tau = ShakenPlane::Real(shaken.scenario.drive.angular_frequency) * t;
        const Sample at = run.at(t);
        const double x = static_cast<double>(exact.position(tau)),
                     u = static_cast<double>(exact.velocity(tau));
        EXPECT_NEAR((at.position / shaken.unit() - x * shaken.line()).norm(), 0, 2e-13 + 2e-14 * std::abs(x))
            << t;
        EXPECT_NEAR((at.velocity / speed - u * shaken.line()).norm(), 0, 2e-13) << t;
      }
    }
}

/// Slips begin and end at the instants of the closed form, to 1e-12 of the period.
TEST(ShakenPlane, ComesLooseAndRestsAtTheInstants) {
  for (const double eta : {0.56, 0.7, 0.9, 0.99}) {
    SCOPED_TRACE(eta);
    const Shaken shaken(eta, 0.4, 5);
    const ShakenPlane exact(eta, 10 * ShakenPlane::kPi);
    const Trajectory run = integrate(shaken.scenario);
    const double off = 1e-12 * 2 * pi / shaken.scenario.drive.angular_frequency;
    const auto state = [&](double t) { return run.at(t).state; };
    EXPECT_NEAR(static_cast<double>(exact.slips().front().begin), std::asin(eta), 1e-15);
    for (const ShakenPlane::Slip& slip : exact.slips()) {
      const double begin = shaken.time(slip.begin), end = shaken.time(slip.end);
      if (end + off > run.end_time()) continue;
      EXPECT_EQ(state(begin - off), State::stick);
      EXPECT_EQ(state(begin + off), State::slip);
      EXPECT_EQ(state(end - off), State::slip);
      EXPECT_EQ(state(end + off), State::stick);
    }
    EXPECT_GE(run.summary().stops, 9);
  }
}

TEST(ShakenPlane, NeverMovesWhereFrictionHolds) {
  for (const double eta : {1.0 + 1e-12, 2.0})
    EXPECT_EQ(integrate(Shaken(eta, 1.1).scenario).end().position.norm(), 0);
  EXPECT_GT(integrate(Shaken(1 - 1e-6, 1.1).scenario).end().position.norm(), 0);
}

/// Rests between slips iff eta > 2/sqrt(pi^2 + 4).
TEST(ShakenPlane, RestsAppearAtTheBoundary) {
  const double boundary = static_cast<double>(ShakenPlane::least_eta_with_rests());
  EXPECT_NEAR(boundary, 0.5370, 5e-5);
  const auto rest_in_last_cycle = [](double eta) {
    const auto rests = [&](double cycles) {
      IntegrationOptions every;
      every.reuse_repeating_cycles = false;
      return integrate(Shaken(eta, 0.7, cycles).scenario, every).summary().stick_time;
    };
    return rests(40) - rests(39);
  };
  for (const double off : {1e-2, 1e-4, 1e-6}) {
    EXPECT_EQ(rest_in_last_cycle(boundary * (1 - off)), 0) << off;
    EXPECT_GT(rest_in_last_cycle(boundary * (1 + off)), 0) << off;
  }
}

/// The periodic motion without rests: it turns at cos(tau) = pi eta/2 and goes 2 sqrt(1 - (pi eta/2)^2)
/// either way.
TEST(ShakenPlane, PeriodicSlipTurnsWhereItMust) {
  for (const double eta : {0.1, 0.3, 0.5, 0.53}) {
    SCOPED_TRACE(eta);
    Shaken shaken(eta, -0.9, 1);
    const double turn = std::acos(pi * eta / 2), way = 2 * std::sin(turn);
    shaken.scenario.start = Start::steady;
    const Trajectory run = integrate(shaken.scenario);
    const double speed = shaken.unit() * shaken.scenario.drive.angular_frequency;
    EXPECT_NEAR(run.at(shaken.time(turn)).velocity.norm() / speed, 0, 1e-12);
    EXPECT_NEAR(run.at(shaken.time(turn + pi)).velocity.norm() / speed, 0, 1e-12);
    const Vector2d gone = run.at(shaken.time(turn + pi)).position - run.at(shaken.time(turn)).position;
    EXPECT_NEAR((gone / shaken.unit() - way * shaken.line()).norm(), 0, 1e-12);
    EXPECT_NEAR(run.end().position.norm() / shaken.unit(), 0, 1e-12);
  }
}

/// Put onto a belt that runs at V with velocity v: in the belt's frame a straight line against constant
/// friction, in the camera's a parabola, until it goes with the belt.
TEST(PartOnABelt, IsAParabolaUntilItGoesWithTheBelt) {
  const double mu = 0.23;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 20; ++k) {
    const Vector2d belt(normal(random), normal(random)), thrown(normal(random), normal(random));
    Scenario s;
    s.drive.amplitude = s.drive.amplitude_y = 0;
    s.friction = {mu, mu, 0, 0, 0};
    s.initial_velocity = thrown - belt;
    const double slowing = mu * s.drive.gravity, stop = s.initial_velocity.norm() / slowing;
    const Vector2d way = s.initial_velocity.normalized();
    s.duration = 1.3 * stop;
    IntegrationOptions options;
    options.derivatives = {Parameter::mu1, Parameter::velocity_x, Parameter::velocity_y};
    const Trajectory run = integrate(s, options);
    for (const double share : {0.1, 0.5, 0.9, 0.999}) {
      const double t = share * stop;
      const Vector2d in_camera = thrown * t - 0.5 * slowing * t * t * way;
      EXPECT_NEAR((run.at(t).position + belt * t - in_camera).norm(), 0, 1e-15 * (1 + in_camera.norm()));
    }
    const Vector2d place = 0.5 * stop * (thrown + belt);  // in the camera's frame, where it first goes along
    EXPECT_NEAR((run.at(stop).position + belt * stop - place).norm(), 0, 2e-15 * (1 + place.norm()));
    EXPECT_EQ(run.at(stop * (1 - 1e-12)).state, State::slip);
    EXPECT_EQ(run.at(stop * (1 + 1e-12)).state, State::stick);
    // The place on the belt, u |u| / (2 mu g), and its derivatives.
    const SensitiveSample end = run.sensitive_end();
    const Vector2d& u = s.initial_velocity;
    const Vector2d on_belt = u * u.norm() / (2 * slowing);
    EXPECT_NEAR((end.sample.position - on_belt).norm(), 0, 1e-15 * (1 + on_belt.norm()));
    EXPECT_NEAR((end.position_jacobian.col(0) + on_belt / mu).norm(), 0, 1e-12);
    const Eigen::Matrix2d by_velocity =
        (u.norm() * Eigen::Matrix2d::Identity() + u * u.transpose() / u.norm()) / (2 * slowing);
    EXPECT_NEAR((end.position_jacobian.rightCols<2>() - by_velocity).norm(), 0, 1e-12);
  }
}

}  // namespace
}  // namespace tribotrack::model
