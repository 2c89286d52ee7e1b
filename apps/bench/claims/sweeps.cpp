#include "apps/bench/claims/sweeps.h"

#include <algorithm>
#include <cstdio>

#include "model/alpha_v.h"
#include "model/batch.h"
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

std::vector<double> steady_v(const std::vector<Scenario>& scenarios) {
  BatchOptions options;
  options.ends = false;
  options.steady = true;
  std::vector<double> v;
  for (const BatchSteady& steady : solve_batch(scenarios, options).steady)
    v.push_back(steady.status == BatchStatus::done ? steady.v : NAN);
  return v;
}

std::vector<double> v_from_rest(const std::vector<Scenario>& scenarios) {
  std::vector<double> v;
  for (const BatchEnd& end : solve_batch(scenarios).ends)
    v.push_back(end.status == BatchStatus::done ? end.v : NAN);
  return v;
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

double deepest_step_back(const std::vector<double>& v, int sign) {
  double from = v.front(), deepest = 0;
  for (const double here : v) {
    if (sign * (here - from) >= 0) from = here;
    if (const double step = std::fabs(here - from); from != 0)
      deepest = std::max(deepest, step / std::fabs(from));
  }
  return deepest;
}

std::string text_of(const char* format, double a) {
  char text[200];
  std::snprintf(text, sizeof text, format, a);
  return text;
}

std::string text_of(const char* format, double a, double b) {
  char text[200];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

std::string conditions(double mu1, double dtau) {
  return text_of("mu1 = %g, dtau = %.3f rad", mu1, dtau);
}

std::string mu1_is(double mu1) {
  return text_of("mu1 = %g", mu1);
}

}  // namespace tribotrack::bench
