#include "apps/bench/claims/sweeps.h"

#include <algorithm>

#include "model/alpha_v.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

using std::numbers::pi;

Drift steady_drift(const Scenario& scenario) {
  const auto orbit = steady_orbit(scenario);
  if (!orbit) return {};
  return {orbit->alpha(), orbit->mean_velocity(scenario.drive.angular_frequency)};
}

Drift drift_from_rest(const Scenario& scenario) {
  const Eigen::Vector2d end = integrate(scenario).end().position;
  return {displacement_angle(end), end.norm() / scenario.end_time()};
}

std::vector<double> grid(double from, double to, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(from + (to - from) * i / (count - 1));
  return values;
}

double turn_between(double from, double to) {
  return std::remainder(to - from, 2 * pi);
}

double degrees(double radians) {
  return radians * 180 / pi;
}

double max_of(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

PhaseSweep sweep_phase(Scenario scenario, const DriftOf& drift, int count) {
  const double start = scenario.friction.phase;
  std::vector<double> off, v;
  double first = 0;
  for (int i = 0; i < count; ++i) {
    scenario.friction.phase = start + 2 * pi * i / count;
    const Drift d = drift(scenario);
    const double sum = d.alpha + scenario.friction.phase;  // constant on a line of slope -1
    if (i == 0) first = sum;
    off.push_back(turn_between(first, sum));
    v.push_back(d.v);
  }
  double mean = 0, mean_v = 0;
  for (int i = 0; i < count; ++i) {
    mean += off[static_cast<size_t>(i)] / count;
    mean_v += v[static_cast<size_t>(i)] / count;
  }
  PhaseSweep sweep;
  for (const double o : off) sweep.off_line = std::max(sweep.off_line, std::fabs(o - mean));
  sweep.v_spread = (max_of(v) - *std::min_element(v.begin(), v.end())) / mean_v;
  return sweep;
}

Monotony monotony(const std::vector<double>& swept, const std::vector<double>& v, int sign) {
  const double rounding = 1e-9 * max_of(v);
  Monotony m;
  for (size_t i = 1; i < v.size(); ++i) {
    const bool against = sign * (v[i] - v[i - 1]) < -rounding;
    if (against && m.holds) m.fails_from = swept[i - 1];
    if (against) {
      m.holds = false;
      m.fails_to = swept[i];
    } else if (!m.holds) {
      break;
    }
  }
  return m;
}

}  // namespace tribotrack::bench
