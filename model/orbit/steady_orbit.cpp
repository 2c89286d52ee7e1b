#include "model/steady_orbit.h"

#include <cmath>
#include <string>

#include "model/orbit/orbit.h"
#include "model/solver/set_up.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace internal {
namespace {

/// The one-cycle map U -> P(U) at the local phase 0, and the cycle's displacement D(U).
struct CycleMap {
  Eigen::Vector2d end, drift;             ///< P(U), D(U)
  Eigen::Matrix2d jacobian, drift_slope;  ///< dP/dU, dD/dU
};

/// Its steps are taken off those that `in` has left.
CycleMap one_cycle(SolverInput<Jet<2>>& in, const Eigen::Vector2d& u, ArcMemory& memory) {
  Pair<Jet<2>> start{u.x(), u.y()};
  start.x.d[0] = start.y.d[1] = 1;
  Solver<Jet<2>> solver(in);
  const Motion<Jet<2>> m = solver.run_one_cycle(in.edges.open_at_start && !in.circling, start, memory);
  in.max_steps -= solver.counts().steps;
  const auto values = [](const Pair<Jet<2>>& a) { return Eigen::Vector2d(a.x.v, a.y.v); };
  const auto slopes = [](const Pair<Jet<2>>& a) {
    return Eigen::Matrix2d{{a.x.d[0], a.x.d[1]}, {a.y.d[0], a.y.d[1]}};
  };
  return {values(m.velocity), values(m.position), slopes(m.velocity), slopes(m.position)};
}

/// The circle at constant friction where that is the motion (section 2.2 of the paper: the end state at
/// constant mu), else the motion without friction.
Eigen::Vector2d first_guess(const ScaledProblem<Jet<2>>& problem, bool with_pulses) {
  const auto d = values(problem.drive);
  const double kappa = problem.kappa_nominal.v;
  const double a = length(d.p);
  const bool circular = std::fabs(a - length(d.q)) < 1e-9 * a && std::fabs(dot(d.p, d.q)) < 1e-9 * a * a &&
                        d.constant.x == 0 && d.constant.y == 0;
  if (!with_pulses && circular && kappa < a) {
    const double speed = std::sqrt((a - kappa) * (a + kappa));
    const double turn = d.p.x * d.q.y - d.p.y * d.q.x > 0 ? 1 : -1;
    const double angle = std::atan2(d.p.y, d.p.x) - turn * std::atan2(speed, kappa);
    return speed * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  return {-d.q.x, -d.q.y};
}

/// Where friction is weak the velocity keeps close to m + c(s), the motion without friction about its centre
/// m, and a cycle's friction has to make up for the mean drive alone: int kappa n ds = 2 pi d_mean. That is
/// the m at which int kappa |m + c| ds - 2 pi d_mean.m is least, a geometric median; found by Weiszfeld's
/// iteration.
Eigen::Vector2d weak_friction_guess(const SolverInput<Jet<2>>& in) {
  constexpr int kSamples = 12;
  const auto d = values(in.problem.drive);
  const auto& e = in.edges.edge;
  const bool pulses = in.edges.count == 2;
  double x[2 * kSamples], y[2 * kSamples], weight[2 * kSamples], blur[2 * kSamples];
  int count = 0;
  for (int i = 0; i < (pulses ? 2 : 1); ++i) {
    const double from = pulses ? e[i].s : 0;
    const double width = !pulses ? kTwoPi : i == 0 ? e[1].s - e[0].s : kTwoPi - (e[1].s - e[0].s);
    const double kappa = (pulses && e[i].opens ? in.problem.kappa_reduced : in.problem.kappa_nominal).v;
    for (int k = 0; k < kSamples; ++k, ++count) {
      const double s = from + width * (k + 0.5) / kSamples, c = std::cos(s), sine = std::sin(s);
      x[count] = d.p.x * sine - d.q.x * c;
      y[count] = d.p.y * sine - d.q.y * c;
      weight[count] = kappa * width / kSamples;
      blur[count] = 0.3 * width / kSamples;
    }
  }
  Eigen::Vector2d m = Eigen::Vector2d::Zero();
  for (int i = 0; i < 60; ++i) {
    Eigen::Vector2d sum(kTwoPi * d.constant.x, kTwoPi * d.constant.y);
    double total = 0, nearest = HUGE_VAL;
    for (int k = 0; k < count; ++k) {
      const double ux = m.x() + x[k], uy = m.y() + y[k];
      const double distance = std::sqrt(ux * ux + uy * uy + blur[k] * blur[k]);
      const double w = weight[k] / distance;
      sum -= w * Eigen::Vector2d(x[k], y[k]);
      total += w;
      if (weight[k] > 0) nearest = std::fmin(nearest, distance);
    }
    const Eigen::Vector2d next = sum / total;
    const double moved = (next - m).norm();
    m = next;
    if (!(moved > 0.01 * nearest)) break;
  }
  return m - Eigen::Vector2d(d.q.x, d.q.y);
}

/// Whether a cycle's friction changes the velocity by little.
bool friction_is_weak(const SolverInput<Jet<2>>& in) {
  const auto& e = in.edges.edge;
  const double first = in.edges.count == 2 ? e[1].s - e[0].s : 0;
  const double open = e[0].opens ? first : in.edges.count == 2 ? kTwoPi - first : 0;
  const double impulse = in.problem.kappa_nominal.v * (kTwoPi - open) + in.problem.kappa_reduced.v * open;
  return impulse < 0.5 * std::fmax(length(in.problem.drive.p), length(in.problem.drive.q));
}

/// Friction must be able to hold the mean of the drive, else the part runs away; and there must be some.
bool attracts(const Scenario& s, bool with_pulses) {
  const double open = with_pulses ? s.friction.pulse_width / kTwoPi : 0;
  const double mean = s.friction.nominal * (1 - open) + s.friction.reduced * open;
  return mean > 0 && std::hypot(std::sin(s.drive.tilt_x), std::sin(s.drive.tilt_y)) < mean;
}

Scenario without_start(Scenario scenario) {
  scenario.start = Start::rest;
  scenario.initial_velocity.setZero();
  return scenario;
}

/// Whether friction holds a part at rest through the whole cycle.
bool always_held(const SolverInput<Jet<2>>& in) {
  const auto held = [&](const Jet<2>& kappa) {
    const Excess excess(in.problem.drive, kappa.v);
    return excess.holds(0) && excess.release(0, kTwoPi) >= kTwoPi;
  };
  return held(in.problem.kappa_nominal) && (in.edges.count == 0 || held(in.problem.kappa_reduced));
}

/// Where a cycle and the one after it stop and end alike: nothing is remembered, the derivatives are 0.
std::optional<Orbit> from_stop_to_stop(const Scenario& scenario, bool with_pulses, SolverInput<Jet<2>>& in,
                                       const Eigen::Vector2d& start) {
  const double kappa = std::fmax(in.problem.kappa_nominal.v, in.problem.kappa_reduced.v);
  if (!Excess(in.problem.drive, kappa).may_hold()) return std::nullopt;
  SolverInput<double> plain = set_up<double>(scenario, {}, with_pulses);
  plain.tolerance = in.tolerance;
  Pair<double> u{start.x(), start.y()};
  for (int i = 1; i <= 2; ++i) {
    ArcMemory memory;
    plain.max_steps = in.max_steps;
    Solver<double> solver(plain);
    const Motion<double> end = solver.run_one_cycle(in.edges.open_at_start && !in.circling, u, memory);
    in.max_steps -= solver.counts().steps;
    if (!(solver.counts().stick_phase > 0)) return std::nullopt;
    if (i == 2 && length(end.velocity - u) <= 4 * in.tolerance * std::fmax(0.25, length(u)))
      return Orbit{{u.x, u.y}, {end.position.x, end.position.y}, Eigen::Matrix2d::Zero(), i};
    u = end.velocity;
  }
  return std::nullopt;
}

/// U = P(U) to the tolerance of `in`, with a Jacobian good to `jacobian_error`: Newton's method, its step cut
/// until it gains, and a plain cycle where no step does. Two motions never separate, so that a cycle cannot
/// lead away.
std::optional<Orbit> solve_cycle(SolverInput<Jet<2>>& in, Eigen::Vector2d u, double jacobian_error) {
  constexpr int kMost = 200;
  ArcMemory memory;
  Eigen::Vector2d newton = Eigen::Vector2d::Zero(), cycle_end = newton;
  Orbit best{u, newton, Eigen::Matrix2d::Identity(), 0};
  double best_error = HUGE_VAL, share = 1;
  bool accept = true;
  for (int i = 1; i <= kMost; ++i) {
    const CycleMap map = one_cycle(in, u, memory);
    const Eigen::Vector2d gap = map.end - u;
    const double error = gap.norm(), scale = std::max(0.25, u.norm());
    if (!std::isfinite(error)) break;
    const bool better = error < (1 - 0.3 * share) * best_error;
    if (!better && best_error < 1e-14) break;
    if (better || accept) {
      best = {u, map.drift, map.jacobian, i};
      best_error = error;
      if (error <= 4 * in.tolerance * scale) return best;
      newton = (Eigen::Matrix2d::Identity() - map.jacobian).fullPivLu().solve(gap);
      cycle_end = map.end;
      share = std::fmin(1, 4 * share);
      // The step leaves an error of second order, and the Jacobian is off by one of first order.
      const double step = newton.norm() / scale;
      if (step < jacobian_error && 10 * step * step <= in.tolerance)
        return Orbit{u + newton, map.drift + map.drift_slope * newton, map.jacobian, i};
    } else {
      share /= 4;
    }
    accept = share < 0.01 || !newton.allFinite() || newton.norm() >= 1e3 * (1 + u.norm());
    u = accept ? cycle_end : best.velocity + share * newton;
  }
  if (best_error < 1e-12) return best;
  return std::nullopt;
}

/// Tolerance at which orbits are looked for before they are found to the tolerance asked for.
inline constexpr double kLoose = 1e-5;

std::optional<Orbit> search(const Scenario& scenario, bool with_pulses, double tolerance,
                            double jacobian_error, long max_steps) {
  if (!attracts(scenario, with_pulses)) return std::nullopt;
  const Scenario free = without_start(scenario);
  auto in = set_up<Jet<2>>(free, {}, with_pulses);
  in.tolerance = tolerance;
  in.max_steps = max_steps;
  if (always_held(in))
    return Orbit{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Matrix2d::Zero(), 0};
  // Cheap ways first: what they leave is squared by the next Newton step.
  int iterations = 0;
  Eigen::Vector2d u =
      with_pulses && friction_is_weak(in) ? weak_friction_guess(in) : first_guess(in.problem, with_pulses);
  if (auto orbit = from_stop_to_stop(free, with_pulses, in, u)) return orbit;
  if (kLoose > tolerance) {
    in.tolerance = kLoose;
    if (const auto orbit = solve_cycle(in, u, 1)) {
      u = orbit->velocity;
      iterations = orbit->iterations;
    }
  }
  in.tolerance = tolerance;
  auto orbit = solve_cycle(in, u, jacobian_error);
  if (orbit) orbit->iterations += iterations;
  return orbit;
}

}  // namespace

std::optional<Orbit> find_orbit(const Scenario& scenario, bool with_pulses, double tolerance,
                                double jacobian_error, long max_steps) try {
  return search(scenario, with_pulses, tolerance, jacobian_error, max_steps);
} catch (const StepLimitExceeded&) {  // which tells of the steps that were left for one cycle
  throw StepLimitExceeded("the periodic motion was not found in max_steps = " + std::to_string(max_steps) +
                          " steps: friction next to nothing; let the run start at rest");
}

}  // namespace internal

std::optional<SteadyOrbit> steady_orbit(const Scenario& scenario, bool with_pulses) {
  scenario.validate();
  const auto found = internal::find_orbit(scenario, with_pulses, 1e-16, 1e-5, IntegrationOptions{}.max_steps);
  if (!found) return std::nullopt;
  const double unit = internal::velocity_unit(scenario);
  SteadyOrbit orbit;
  orbit.velocity = unit * found->velocity;
  orbit.drift = unit / scenario.drive.angular_frequency * found->drift;
  orbit.contraction = found->contraction();
  orbit.newton_iterations = found->iterations;
  return orbit;
}

double SteadyOrbit::mean_velocity(double angular_frequency) const {
  return drift.norm() * angular_frequency / internal::kTwoPi;
}

}  // namespace tribotrack::model
