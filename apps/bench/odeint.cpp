// Boost.odeint's controlled steppers on eq. (5).
#include <boost/numeric/odeint.hpp>

#include "apps/bench/equation.h"

namespace tribotrack::bench {

using namespace model;

namespace {

namespace odeint = boost::numeric::odeint;

using Equation = PlainEquation<double>;
using State = Equation::State;

/// In units of A and A w, so that one tolerance serves both.
struct Slope {
  const Equation* f;
  Scales scales;
  double m = 0;
  void operator()(const State& q, State& dqdt, double t) const {
    const State si{q[0] * scales.length, q[1] * scales.length, q[2] * scales.speed, q[3] * scales.speed};
    const State d = f->slope(t, si, m, true);
    dqdt = {d[0] / scales.length, d[1] / scales.length, d[2] / scales.speed, d[3] / scales.speed};
  }
};

template <class Stepper>
struct Controlled {
  decltype(odeint::make_controlled<Stepper>(0.0, 0.0)) stepper;
  explicit Controlled(double tolerance) : stepper(odeint::make_controlled<Stepper>(tolerance, tolerance)) {}
  void begin_segment() {
    if constexpr (requires { stepper.reset(); }) stepper.reset();
  }
};
struct BulirschStoer {
  odeint::bulirsch_stoer<State> stepper;
  explicit BulirschStoer(double tolerance) : stepper(tolerance, tolerance) {}
  void begin_segment() { stepper.reset(); }
};

/// Steps to `until`; calls stopped() after each and ends early when it says so. Keeps the step size from
/// segment to segment.
template <class Method, class Stopped>
void step_to(Method& method, const Slope& slope, double until, double& h, Progress<double>& p,
             Stopped&& stopped) {
  method.begin_segment();
  State q{p.q[0] / slope.scales.length, p.q[1] / slope.scales.length, p.q[2] / slope.scales.speed,
          p.q[3] / slope.scales.speed};
  while (p.t < until && p.within_budget()) {
    const double left = until - p.t;
    const bool last = h >= left * (1 - 1e-12);
    double step = last ? left : h;
    const State before = p.q;
    ++p.steps;
    if (method.stepper.try_step(slope, q, p.t, step) != odeint::success) {
      h = step;
      continue;
    }
    if (last) p.t = until;
    // A step cut short by the end of the segment says nothing against the longer one.
    h = last ? std::max(h, step) : step;
    p.q = {q[0] * slope.scales.length, q[1] * slope.scales.length, q[2] * slope.scales.speed,
           q[3] * slope.scales.speed};
    if (stopped(before)) return;
  }
}

template <class Method>
PeerResult solve(const Scenario& scenario, double tolerance, long max_steps) {
  const Equation f(scenario);
  const Scales scales(scenario);
  Method method(tolerance);
  double h = 1e-3 / f.frequency();
  Slope slope{&f, scales};
  const double small = stop_speed(scales, tolerance);
  return run_in_segments(f, Progress<double>(scenario, max_steps), [&](auto& at, double until, double m) {
    slope.m = m;
    step_to(method, slope, until, h, at, [&](const State& before) { return stops(f, before, m, small, at); });
  });
}

}  // namespace

std::vector<BenchPeer> odeint_peers() {
  return {{"odeint Dormand-Prince 5(4)", solve<Controlled<odeint::runge_kutta_dopri5<State>>>},
          {"odeint Fehlberg 7(8)", solve<Controlled<odeint::runge_kutta_fehlberg78<State>>>},
          {"odeint Bulirsch-Stoer", solve<BulirschStoer>}};
}

}  // namespace tribotrack::bench
