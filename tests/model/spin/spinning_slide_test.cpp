// Free slides that spin, against brute force and against the laws they must keep.

#include <gtest/gtest.h>

#include <cmath>

#include "model/spinning_disc.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

Scenario slide(double mu, double speed, double spin_ratio, double radius = 0.0155) {
  Scenario s;
  s.drive.amplitude = s.drive.amplitude_y = 0;
  s.friction = {mu, 0, 0, 0, 0};
  s.initial_velocity = {0.8 * speed, 0.6 * speed};
  s.spin = {spin_ratio * speed / radius, radius, 0.5};
  s.duration = (1.5 + spin_ratio) * speed / (mu * s.drive.gravity);
  return s;
}

TEST(SpinningSlide, WithoutSpinItIsTheParabola) {
  IntegrationOptions options;
  options.derivatives = {Parameter::mu1, Parameter::velocity_x, Parameter::spin};
  Scenario spinning = slide(0.2, 0.5, 0), still = spinning;
  still.spin = {};
  const Trajectory run = integrate(spinning, options);
  options.derivatives.pop_back();
  const Trajectory parabola = integrate(still, options);
  for (double t = 0; t < run.end_time(); t += 0.01) {
    const SensitiveSample a = run.sensitive_at(t), b = parabola.sensitive_at(t);
    EXPECT_NEAR((a.sample.position - b.sample.position).norm(), 0, 1e-14);
    EXPECT_NEAR((a.position_jacobian.leftCols(2) - b.position_jacobian).norm(), 0, 1e-9);
    EXPECT_EQ(a.position_jacobian.col(2).norm(), 0) << "even in the spin";
  }
  // And smoothly: the way is longer by a share of the spin's square.
  const double way = parabola.end().position.norm();
  const double more = integrate(slide(0.2, 0.5, 1e-3)).end().position.norm() / way - 1;
  const double four = integrate(slide(0.2, 0.5, 2e-3)).end().position.norm() / way - 1;
  EXPECT_GT(more, 1e-7);
  EXPECT_NEAR(four / more, 4, 0.01);
}

TEST(SpinningSlide, LosesItsEnergyToFriction) {
  // d/dt (u^2/2 + k w^2/2) = -mu g (u F + w T).
  const Trajectory run = integrate(slide(0.17, 0.6, 1.3));
  const auto energy = [&](double t) {
    const Sample s = run.at(t);
    return 0.5 * s.velocity.squaredNorm() + 0.25 * std::pow(s.spin * 0.0155, 2);
  };
  for (const double t : {0.05, 0.2, 0.3}) {
    const Sample s = run.at(t);
    const double u = s.velocity.norm(), w = s.spin * 0.0155, h = 1e-4;
    const test::FaceForce face = test::force_by_directions(u, w);
    EXPECT_NEAR((energy(t + h) - energy(t - h)) / (2 * h), -0.17 * 9.81 * (u * face.force + w * face.torque),
                1e-7);
  }
}

TEST(SpinningSlide, SignOfTheSpinOnlyTurnsTheAngle) {
  Scenario other = slide(0.17, 0.6, 1.5);
  const Trajectory left = integrate(other);
  other.spin.rate = -other.spin.rate;
  const Trajectory right = integrate(other);
  EXPECT_EQ(left.end().position, right.end().position);
  EXPECT_EQ(left.end().angle, -right.end().angle);
}

TEST(SpinningSlide, DerivativesAreThoseOfTheMotion) {
  IntegrationOptions options;
  options.derivatives = {Parameter::mu1,    Parameter::velocity_x, Parameter::velocity_y, Parameter::spin,
                         Parameter::tilt_x, Parameter::gravity,    Parameter::inertia,    Parameter::viscous};
  for (const double ratio : {0.4, 0.9, 2.0}) {
    Scenario base = slide(0.17, 0.6, ratio);
    base.viscous = 0.8;
    const Trajectory run = integrate(base, options);
    for (const double t : {0.15, 0.33, base.duration}) {
      const SensitiveSample at = run.sensitive_at(t);
      for (Eigen::Index j = 0; j < at.position_jacobian.cols(); ++j) {
        const Parameter p = options.derivatives[static_cast<std::size_t>(j)];
        const double h = 1e-5 * std::max(std::abs(base.get(p)), 0.1);
        Scenario up = base, down = base;
        up.set(p, base.get(p) + h);
        down.set(p, base.get(p) - h);
        const Sample a = integrate(up).at(t), b = integrate(down).at(t);
        const Eigen::Vector2d slope = (a.position - b.position) / (2 * h);
        EXPECT_NEAR((at.position_jacobian.col(j) - slope).norm(), 0, 2e-5 * (0.01 + slope.norm()))
            << to_string(p) << " ratio " << ratio << " t " << t;
        EXPECT_NEAR(at.angle_jacobian(j), (a.angle - b.angle) / (2 * h),
                    2e-4 * (1 + std::abs(at.angle_jacobian(j))))
            << to_string(p) << " ratio " << ratio << " t " << t;
      }
    }
  }
}

// Without spin v' = -(a + c v): x = (v0 + a/c) (1 - exp(-c t))/c - a t/c until ln(1 + c v0/a)/c.
TEST(SpinningSlide, ViscousFrictionIsAnExponential) {
  const double mu = 0.17, speed = 0.6, a = mu * 9.81;
  for (const double c : {0.01, 0.84, 20.0}) {
    Scenario s = slide(mu, speed, 0);
    s.spin = {};
    s.viscous = c;
    const Trajectory run = integrate(s, {.tolerance = 1e-13, .derivatives = {}});
    const double stop = std::log1p(c * speed / a) / c;
    EXPECT_NEAR(run.end_time() - run.summary().stick_time, stop, 1e-8 * stop);
    for (const double share : {0.1, 0.5, 0.9, 1.0, 1.2}) {
      const double t = std::min(share, 1.0) * stop;
      const double way = (speed + a / c) * -std::expm1(-c * t) / c - a * t / c;
      EXPECT_NEAR(run.at(share * stop).position.norm(), way, 1e-10 * std::max(1.0, 1 / c))
          << c << " " << share;
    }
  }
  Scenario driven = slide(mu, speed, 0);
  driven.spin = {};
  driven.viscous = 1;
  driven.drive.amplitude = 1e-3;
  EXPECT_THROW(integrate(driven), InvalidParameter);
}

TEST(SpinningSlide, GoesOnDownASteepSlope) {
  Scenario s = slide(0.05, 0.3, 1.0);
  s.drive.tilt_x = 0.2;  // steeper than the friction
  s.duration = 2;
  const Trajectory run = integrate(s);
  EXPECT_EQ(run.summary().stops, 0);
  EXPECT_NEAR((run.at(2).velocity.x() - run.at(1.9).velocity.x()) / 0.1, 9.81 * (std::sin(0.2) - 0.05), 0.01);
}

TEST(SpinningSlide, IsRefusedWhereNothingFollowsIt) {
  Scenario s = slide(0.17, 0.6, 1);
  s.spin.radius = 0;
  EXPECT_THROW(integrate(s), InvalidParameter);
  s = slide(0.17, 0.6, 1);
  s.drive.amplitude = 1e-3;
  EXPECT_THROW(integrate(s), InvalidParameter);
}

}  // namespace
}  // namespace tribotrack::model
