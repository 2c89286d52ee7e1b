// Derivatives of model/trajectory.h against differences in quadruple precision.
#include <gtest/gtest.h>

#include "model/laws.h"
#include "model/quad_reference.h"
#include "model/random_scenario.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

using laws::kPi;
using reference::quad;
using reference::QuadScenario;

constexpr std::array kAll = {
    Parameter::mu1,         Parameter::mu2,        Parameter::lag,         Parameter::phi,
    Parameter::dtau,        Parameter::amplitude,  Parameter::amplitude_y, Parameter::angular_frequency,
    Parameter::phase_shift, Parameter::gravity,    Parameter::tilt_x,      Parameter::tilt_y,
    Parameter::velocity_x,  Parameter::velocity_y, Parameter::start_phase};

/// A size over which the motion changes noticeably with the parameter.
double natural_size(const Scenario& s, Parameter p) {
  const double w = s.drive.angular_frequency, a = s.drive.amplitude * w * w;
  switch (p) {
    case Parameter::mu1:
    case Parameter::mu2:
      return a / s.drive.gravity;
    case Parameter::amplitude:
    case Parameter::amplitude_y:
      return s.drive.amplitude;
    case Parameter::angular_frequency:
      return w;
    case Parameter::gravity:
      return s.drive.gravity;
    case Parameter::tilt_x:
    case Parameter::tilt_y:
      return a / s.drive.gravity;
    case Parameter::velocity_x:
    case Parameter::velocity_y:
      return a / w;
    default:
      return 1;
  }
}

/// Errors of d(end)/dp, relative to (how far the part gets)/(natural size of p).
void expect_derivatives(const Scenario& s, bool from_moving) {
  IntegrationOptions options;
  options.derivatives.assign(kAll.begin(), kAll.end());
  const Trajectory t = integrate(s, options);
  const SensitiveSample end = t.sensitive_end();
  for (size_t j = 0; j < kAll.size(); ++j) {
    const Parameter p = kAll[j];
    // From rest the motion has a kink in the initial velocity.
    if (!from_moving && (p == Parameter::velocity_x || p == Parameter::velocity_y)) continue;
    const quad step = 1e-5 * natural_size(s, p);
    const auto at = [&](int n) {
      QuadScenario q(s);
      q[p] += n * step;
      return reference::integrate(q);
    };
    const auto a = at(-2), b = at(-1), c = at(1), d = at(2);
    const auto slope = [&](const auto field) {
      return static_cast<double>((8 * (c.*field - b.*field) - (d.*field - a.*field)) / (12 * step));
    };
    using End = std::remove_cvref_t<decltype(a)>;
    const double dx = slope(&End::x), dy = slope(&End::y);
    const Eigen::Vector2d du(slope(&End::ux), slope(&End::uy));
    const auto of_velocity = end.velocity_jacobian.col(static_cast<Eigen::Index>(j));
    EXPECT_LT(
        (du - of_velocity).norm(),
        1e-9 * std::max(du.norm(), 1e-3 * s.drive.amplitude * s.drive.angular_frequency / natural_size(s, p)))
        << to_string(p);
    const auto column = end.position_jacobian.col(static_cast<Eigen::Index>(j));
    const double scale = std::max(std::hypot(dx, dy), 1e-3 * s.drive.amplitude / natural_size(s, p));
    const double error = std::hypot(dx - column.x(), dy - column.y()) / scale;
    EXPECT_LT(error, 1e-9) << to_string(p) << ": " << column.transpose() << " but differences say " << dx
                           << ' ' << dy;
  }
}

Scenario reference_run() {
  Scenario s;
  s.friction = {0.1, 0.0125, 0.5, kPi / 2, 0.1};
  s.cycles = 2;
  s.start_phase = 0.2;
  return s;
}

/// Through switches while sliding, through stops and releases at edges, on an ellipse with tilt and initial
/// velocity, through a smooth take-off, and at random.
TEST(Sensitivity, OfTheEndIsThatOfTheReference) {
  Scenario slides = reference_run(), sticks = slides, elliptic = slides, takes_off = slides;
  sticks.friction.nominal = 0.13;
  sticks.friction.pulse_width = kPi / 5;
  Scenario held = sticks;
  held.friction.nominal = 0.3;
  elliptic.drive.amplitude_y = 0.2e-3;
  elliptic.drive.phase_shift = 1.1;
  elliptic.drive.tilt_x = 0.01;
  elliptic.drive.tilt_y = -0.02;
  elliptic.initial_velocity = {0.01, 0.02};
  takes_off.friction = {0.12, 0.03, 0.5, 0.4, 0.1};
  takes_off.drive.tilt_x = 0.03;
  takes_off.drive.tilt_y = 0.004;
  takes_off.cycles = 1.3;
  for (const Scenario& s : {sticks, held, takes_off}) ASSERT_GT(integrate(s).summary().stops, 0);
  std::vector<Scenario> scenarios = {slides, sticks, held, elliptic, takes_off};
  RandomScenario random(77);
  for (int i = 0; i < 4; ++i) {
    scenarios.push_back(random.general());
    scenarios.back().cycles = 1;
  }
  for (std::size_t k = 0; k < scenarios.size(); ++k) {
    SCOPED_TRACE("scenario " + std::to_string(k));
    expect_derivatives(scenarios[k], scenarios[k].initial_velocity.norm() > 0);
  }
}

/// A start on the periodic motion moves with the parameters: against differences of the product's own end
/// points.
TEST(Sensitivity, StartsOnOrbits) {
  for (const Start start : {Start::circling, Start::steady}) {
    for (const double mu : {0.08, 0.13}) {
      Scenario s = reference_run();
      s.friction.nominal = mu;
      s.start = start;
      IntegrationOptions options;
      options.derivatives.assign(kAll.begin(), kAll.end());
      const SensitiveSample end = integrate(s, options).sensitive_end();
      for (size_t j = 0; j < kAll.size(); ++j) {
        const Parameter p = kAll[j];
        const double h = 1e-3 * natural_size(s, p);
        const auto central = [&](double step) {
          const auto at = [&](double n) {
            Scenario moved = s;
            moved.set(p, s.get(p) + n * step);
            return integrate(moved).end().position;
          };
          return Eigen::Vector2d((45 * (at(1) - at(-1)) - 9 * (at(2) - at(-2)) + (at(3) - at(-3))) /
                                 (60 * step));
        };
        const Eigen::Vector2d d = central(h);
        const double scale = std::max(d.norm(), 1e-2 * s.drive.amplitude / natural_size(s, p));
        EXPECT_LT((d - end.position_jacobian.col(static_cast<Eigen::Index>(j))).norm(), 1e-8 * scale)
            << to_string(start) << ' ' << mu << ' ' << to_string(p);
      }
    }
  }
}

/// Opening edge on the start from rest: the derivative is that of a later edge, to 1e-9 in quadruple
/// precision; of an earlier one it is another. Over 20 cycles of narrow pulses: -1.30 and -0.97 mm/rad in x.
TEST(Sensitivity, OneSidedInQuadruplePrecision) {
  Scenario s = reference_run();
  s.start_phase = s.friction.phase = s.friction.lag = 0;
  s.cycles = 1;
  IntegrationOptions options;
  options.derivatives = {Parameter::lag};
  const Eigen::Vector2d column = integrate(s, options).sensitive_end().position_jacobian.col(0);
  // Tiny: for a later edge the motion holds a power of lag that is no whole number.
  const quad h = 1e-8;
  const auto at = [&](int n) {
    QuadScenario q(s);
    q[Parameter::lag] = n * h;
    return reference::integrate(q);
  };
  const auto slope = [&](int side) {  // of 4th order
    const auto f0 = at(0), f1 = at(side), f2 = at(2 * side), f3 = at(3 * side), f4 = at(4 * side);
    const auto difference = [&](quad a, quad b, quad c, quad d, quad e) {
      return static_cast<double>((-25 * a + 48 * b - 36 * c + 16 * d - 3 * e) / (12 * side * h));
    };
    return Eigen::Vector2d(difference(f0.x, f1.x, f2.x, f3.x, f4.x),
                           difference(f0.y, f1.y, f2.y, f3.y, f4.y));
  };
  const Eigen::Vector2d later = slope(1), earlier = slope(-1);
  EXPECT_LT((later - column).norm(), 1e-9 * later.norm()) << column << " but differences say " << later;
  EXPECT_GT((later - earlier).norm(), 1e-2 * later.norm());
  s.cycles = 20;
  s.friction.pulse_width = kPi / 6;
  const SensitiveSample end = integrate(s, options).sensitive_end();
  EXPECT_NEAR(1e3 * end.position_jacobian(0, 0), -1.30, 0.005);
  s.friction.lag = -1e-6;
  EXPECT_NEAR(1e3 * (integrate(s).end().position.x() - end.sample.position.x()) / s.friction.lag, -0.97,
              0.005);
}

}  // namespace
}  // namespace tribotrack::model
