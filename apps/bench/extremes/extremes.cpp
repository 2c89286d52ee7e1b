#include "apps/bench/extremes/extremes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "apps/bench/extremes/laws.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using Eigen::Vector2d;

double relative(const Vector2d& difference, double size) {
  const double gap = difference.norm();
  return gap == 0 ? 0 : gap / std::max(size, std::numeric_limits<double>::min());
}

/// The longer of a path and A.
double size_of(const Scenario& s, const Vector2d& end) {
  return std::max({end.norm(), s.drive.amplitude, s.drive.amplitude_y});
}

/// What exceeds a bound, relative to A.
double excess(const Scenario& s, double path, double bound) {
  return std::max(0.0, path - bound) / std::max(s.drive.amplitude, s.drive.amplitude_y);
}

}  // namespace

Vector2d end_of(const Scenario& scenario) {
  return integrate(scenario).end().position;
}

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

double drive_strength(const Scenario& s) {
  return s.drive.amplitude * s.drive.angular_frequency * s.drive.angular_frequency;
}

ExtremeLaw scaling_law() {
  return {"(A/9, 3w): x/A unchanged", 1e-11, [](const Scenario& s, const Vector2d& end) {
            Scenario twin = s;
            twin.drive.amplitude /= 9;
            twin.drive.amplitude_y /= 9;
            twin.drive.angular_frequency *= 3;
            twin.initial_velocity /= 3;
            twin.duration /= 3;
            return relative(9 * end_of(twin) - end, size_of(s, end));
          }};
}

ExtremeLaw same_as(const std::string& text, const Scenario& other, double allowed) {
  return {text, allowed, [other](const Scenario& s, const Vector2d& end) {
            return relative(end - end_of(other), size_of(s, end));
          }};
}

ExtremeLaw ends_at(const std::string& text, const Vector2d& place, double allowed) {
  return {text, allowed,
          [place](const Scenario&, const Vector2d& end) { return relative(end - place, place.norm()); }};
}

ExtremeLaw never_moves() {
  return {"never moves", 0, [](const Scenario&, const Vector2d& end) { return end.norm(); }};
}

ExtremeLaw creeps_at_most(double surplus) {
  return {"path at most (|drive| - mu1 g) T^2/2, exceeded by (of A)", 1e-11,
          [surplus](const Scenario& s, const Vector2d& end) {
            const double time = s.end_time();
            return excess(s, end.norm(), std::max(0.0, surplus) * time * time / 2);
          }};
}

ExtremeLaw never_separates_from(const Scenario& other) {
  return {"|x - x'| <= |u0 - u0'| T, exceeded by (of A)", 1e-11,
          [other](const Scenario& s, const Vector2d& end) {
            const double apart = (s.initial_velocity - other.initial_velocity).norm();
            return excess(s, (end - end_of(other)).norm(), apart * s.end_time());
          }};
}

ExtremeLaw last_half_adds_drifts() {
  return {"last half adds (cycles/2) drifts of the periodic orbit", 1e-11,
          [](const Scenario& scenario, const Vector2d& end) {
            Scenario half = scenario;
            half.cycles /= 2;
            const auto orbit = steady_orbit(scenario);
            if (!orbit) return std::numeric_limits<double>::infinity();
            return relative(end - end_of(half) - half.cycles * orbit->drift, end.norm());
          }};
}

ExtremeLaw stays_on_line(double slope) {
  return {slope > 0 ? "stays on the line y = x" : "stays on the line y = -x", 1e-11,
          [slope](const Scenario& s, const Vector2d& end) {
            return relative(Vector2d(end.y() - slope * end.x(), 0), size_of(s, end));
          }};
}

ExtremeList::ExtremeList(bool only_quick) : quick(only_quick) {
  constexpr double pi = std::numbers::pi;
  slip.name = "slips";
  slip.base.friction = {0.1, 0.0125, 0.5, pi / 2, 0};
  slip.base.cycles = quick ? 2 : 20;
  stick = slip;
  stick.name = "sticks";
  stick.base.friction = {0.122, 0.122 / 8, 0.5, pi / 6, 0};
}

std::vector<ExtremeCase> extreme_cases(bool quick) {
  ExtremeList list(quick);
  list.add("ordinary", list.slip.base, scaling_law());
  list.add("ordinary, sticks", list.stick.base, scaling_law());
  add_friction_extremes(list);
  add_threshold_extremes(list);
  add_pulse_extremes(list);
  add_drive_extremes(list);
  add_start_extremes(list);
  return std::move(list.cases);
}

}  // namespace tribotrack::bench
