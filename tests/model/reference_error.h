// How far the product's end point is from the one in quadruple precision.
#pragma once

#include <algorithm>
#include <cmath>

#include "model/quad_reference.h"
#include "model/trajectory.h"

namespace tribotrack::model::reference {

/// Longest distance from the start, at least 1 % of A: what a relative error is relative to. (At the
/// threshold a - mu1 g is a rounding error of a: shorter paths have no more digits.) On a platform at rest,
/// for the same reason, at least 1e-4 of mu1 g T^2/2.
inline double path_size(const Trajectory& t) {
  const Scenario& s = t.scenario();
  double size = 0.01 * std::max(s.drive.amplitude, s.drive.amplitude_y);
  if (size == 0) size = 0.5e-4 * s.friction.nominal * s.drive.gravity * t.end_time() * t.end_time();
  for (int i = 0; i <= 50; ++i) size = std::max(size, t.at(t.end_time() * i / 50).position.norm());
  return size;
}

/// Distance of positions, or of velocities over w if that is more.
inline double distance(const Trajectory& t, const QuadState& exact) {
  const Sample end = t.end();
  const double dx = std::hypot(static_cast<double>(exact.x - end.position.x()),
                               static_cast<double>(exact.y - end.position.y()));
  const double du = std::hypot(static_cast<double>(exact.ux - end.velocity.x()),
                               static_cast<double>(exact.uy - end.velocity.y()));
  return std::max(dx, du / t.scenario().drive.angular_frequency);
}

/// The same relative to the path.
inline double difference(const Trajectory& t, const QuadState& exact) {
  const double error = distance(t, exact);
  return error == 0 ? 0 : error / path_size(t);
}

/// Error of the end point. A start on a periodic motion is taken from the product: whether it is one is
/// another question, see `return_after_a_cycle`.
inline double error_against_reference(const Scenario& s) {
  const Trajectory t = integrate(s);
  Scenario from = s;
  if (s.start != Start::rest) from.initial_velocity = t.at(0).velocity;
  return difference(t, QuadIntegrator(QuadScenario(from)).run(s.start == Start::circling));
}

/// The largest error of the end point from rest over every way to integrate that is offered to users: dense
/// or not, with repeating cycles or without.
inline double largest_error_against_reference(const Scenario& s) {
  const QuadState exact = QuadIntegrator(QuadScenario(s)).run(false);
  const double size = path_size(integrate(s));
  double largest = 0;
  for (const bool dense : {true, false})
    for (const bool reuse : {true, false}) {
      IntegrationOptions how;
      how.dense = dense;
      how.reuse_repeating_cycles = reuse;
      largest = std::max(largest, distance(integrate(s, how), exact) / size);
    }
  return largest;
}

/// |P(u) - u| of the one-cycle map P in quadruple precision at the product's start, over a/w. As no two
/// motions separate, u is within this over (1 - contraction) of the periodic one.
inline double return_after_a_cycle(Scenario s) {
  const Eigen::Vector2d u = integrate(s).at(0).velocity;
  if (s.start == Start::circling) s.friction.pulse_width = 0;
  s.initial_velocity = u;
  s.duration = 0;
  s.cycles = 1;
  const QuadState end = integrate(QuadScenario(s));
  const double gap = std::hypot(static_cast<double>(end.ux - u.x()), static_cast<double>(end.uy - u.y()));
  return gap / (std::max(s.drive.amplitude, s.drive.amplitude_y) * s.drive.angular_frequency);
}

/// The end point after many cycles: 24 of them, then copies of the last, which repeats the one before to
/// 1e-15 of a/w or the scenario is none for this.
inline QuadState after_many_cycles(Scenario s) {
  const double cycles = s.cycles;
  s.cycles = 23;
  const QuadState before = integrate(QuadScenario(s));
  s.cycles = 24;
  QuadState end = integrate(QuadScenario(s));
  const quad unit = quad(s.drive.amplitude) * s.drive.angular_frequency;
  if (absolute(end.ux - before.ux) + absolute(end.uy - before.uy) > quad(1e-18) * unit)
    throw std::runtime_error("reference: not yet periodic after 24 cycles");
  end.x += (cycles - 24) * (end.x - before.x);
  end.y += (cycles - 24) * (end.y - before.y);
  return end;
}

}  // namespace tribotrack::model::reference
