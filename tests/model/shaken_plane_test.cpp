// The integrator against two closed forms: a mass on a shaken plane (code_aster SDND104), a part on a belt.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "model/scenario.h"
#include "model/trajectory.h"

// A mass on a plane that is shaken along a line, with dry friction, in closed form from phase to phase: the
// validation case SDND104 of code_aster (manual v5.01.104), which knows nothing of this program.
//
// Along the line the drive is a sin(tau), tau = wt, friction mu g = eta a. From rest at tau = 0:
//   eta >= 1: at rest for ever. Else it comes loose at tau = asin(eta) (+ pi n, if it rests then);
//   a slip from tau_0 in the direction d = +-1:
//     u(tau) = (a/w) (cos tau_0 - cos tau - d eta (tau - tau_0)),
//     x(tau) - x_0 = (a/w^2) ((tau - tau_0) cos tau_0 + sin tau_0 - sin tau - d eta (tau - tau_0)^2/2);
//   it ends where u = 0 again: there it rests if |sin tau| <= eta, else it slips the other way.
// Slip follows slip for ever iff eta < 2/sqrt(pi^2 + 4) = 0.537.

namespace tribotrack::model {

/// In units of a/w and a/w^2, extended precision.
class ShakenPlane {
 public:
  using Real = long double;
  struct Slip {
    Real begin, end;  ///< tau
    int direction;    ///< +1 or -1
    Real place;       ///< x_0
  };
  static constexpr Real kPi = std::numbers::pi_v<Real>;

  /// All slips that begin before tau = `until`.
  ShakenPlane(double eta, Real until) : eta_(eta) {
    if (eta_ >= 1) return;
    Slip slip{std::asin(eta_), 0, 1, 0};
    while (slip.begin < until) {
      slip.end = end_of(slip);
      slips_.push_back(slip);
      const Real at_end = std::sin(slip.end), place = slip.place + way(slip, slip.end);
      if (std::abs(at_end) > eta_)
        slip = {slip.end, 0, -slip.direction, place};
      else
        slip = loose_after(slip.end, place);
    }
  }

  const std::vector<Slip>& slips() const { return slips_; }
  Real position(Real tau) const {
    Real x = 0;
    for (const Slip& slip : slips_)
      if (slip.begin < tau) x = slip.place + way(slip, std::min(tau, slip.end));
    return x;
  }
  Real velocity(Real tau) const {
    for (const Slip& slip : slips_)
      if (slip.begin < tau && tau < slip.end) return speed(slip, tau);
    return 0;
  }

 private:
  Real speed(const Slip& slip, Real tau) const {
    return std::cos(slip.begin) - std::cos(tau) - slip.direction * eta_ * (tau - slip.begin);
  }
  Real way(const Slip& slip, Real tau) const {
    const Real t = tau - slip.begin;
    return t * std::cos(slip.begin) + std::sin(slip.begin) - std::sin(tau) -
           slip.direction * eta_ * t * t / 2;
  }
  /// The speed grows to where the drive falls to eta, then falls until the drive has grown to eta again one
  /// period later: by then it would have turned.
  Real end_of(const Slip& slip) const {
    const Real half_turn = slip.direction > 0 ? 0 : kPi;
    const Real turn = std::floor((slip.begin - half_turn) / (2 * kPi)) * 2 * kPi + half_turn;
    Real before = turn + kPi - std::asin(eta_), after = turn + 2 * kPi + std::asin(eta_);
    for (int k = 0; k < 200; ++k) {
      const Real middle = (before + after) / 2;
      (slip.direction * speed(slip, middle) > 0 ? before : after) = middle;
    }
    return before;
  }
  Slip loose_after(Real tau, Real place) const {
    const Real half_turns = std::ceil((tau - std::asin(eta_)) / kPi);
    return {std::asin(eta_) + half_turns * kPi, 0, std::fmod(half_turns, 2) == 0 ? 1 : -1, place};
  }

  Real eta_;
  std::vector<Slip> slips_;
};

/// Its scenario: shaken at `angle` (rad) to x, without pulses, 20 cycles.
inline Scenario shaken_plane_scenario(double eta, double angle) {
  Scenario s;
  const double length = s.drive.amplitude;
  s.drive.amplitude = length * std::abs(std::cos(angle));
  s.drive.amplitude_y = length * std::abs(std::sin(angle));
  s.drive.phase_shift = std::cos(angle) * std::sin(angle) < 0 ? std::numbers::pi : 0;
  s.start_phase = (std::cos(angle) < 0 ? 0.5 : -0.5) * std::numbers::pi;
  const double a = length * s.drive.angular_frequency * s.drive.angular_frequency;
  s.friction = {eta * a / s.drive.gravity, eta * a / s.drive.gravity, 0, 0, 0};
  return s;
}

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
    EXPECT_EQ(run.summary().stops, 1);
    EXPECT_NEAR(run.summary().stick_time, 0.3 * stop, 1e-14 * stop);
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
