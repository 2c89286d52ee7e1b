// Boost.odeint's controlled steppers on eq. (5).
#include <boost/numeric/odeint.hpp>

#include "apps/bench/peers/segments.h"

namespace tribotrack::bench::peers {

using namespace model;

namespace {

namespace odeint = boost::numeric::odeint;

/// In units of A and A w, so that one tolerance serves both.
struct Slope {
  const Equation* f;
  Scales scales;
  double m = 0;
  bool segmented = true;
  void operator()(const State& q, State& dqdt, double t) const {
    const State si{q[0] * scales.length, q[1] * scales.length, q[2] * scales.speed, q[3] * scales.speed};
    const State d = f->slope(t, si, segmented ? m : f->friction(t), segmented);
    dqdt = {d[0] / scales.length, d[1] / scales.length, d[2] / scales.speed, d[3] / scales.speed};
  }
};

using DormandPrince54 = odeint::runge_kutta_dopri5<State>;
using Fehlberg78 = odeint::runge_kutta_fehlberg78<State>;

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
void step_to(Method& method, const Slope& slope, double until, double& h, Progress& p, Stopped&& stopped) {
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
PeerResult solve(const Scenario& scenario, double tolerance, long max_steps, Switching switching) {
  const Equation f(scenario);
  const Scales scales(scenario);
  Method method(tolerance);
  Progress p = start_of(scenario, max_steps);
  double h = 1e-3 / f.frequency();
  Slope slope{&f, scales, 0, switching == Switching::segmented};
  if (switching == Switching::by_clock) {
    step_to(method, slope, f.end(), h, p, [](const State&) { return false; });
    return result_of(p, f.end());
  }
  const double small = stop_speed(scales, tolerance);
  return run_in_segments(f, p, [&](Progress& at, double until, double m) {
    slope.m = m;
    step_to(method, slope, until, h, at, [&](const State& before) { return stops(f, before, m, small, at); });
  });
}

using Solver = PeerResult (*)(const Scenario&, double, long, Switching);

// The same again for processors with AVX2 and FMA: everything inlined into a function compiled for them,
// which is what -march=native would do.
template <class Method>
[[gnu::flatten, gnu::target("avx2,fma")]] PeerResult solve_avx2(const Scenario& scenario, double tolerance,
                                                                long max_steps, Switching switching) {
  return solve<Method>(scenario, tolerance, max_steps, switching);
}

BenchPeer peer(const std::string& name, Solver solver, Switching switching) {
  const char* cut = switching == Switching::segmented ? ", segmented" : ", by clock";
  return {"odeint " + name + cut, [solver, switching](const Scenario& s, double tolerance, long max_steps) {
            return solver(s, tolerance, max_steps, switching);
          }};
}

}  // namespace

std::vector<BenchPeer> odeint_peers() {
  using Dormand = Controlled<DormandPrince54>;
  using Fehlberg = Controlled<Fehlberg78>;
  std::vector<BenchPeer> list;
  for (const Switching switching : {Switching::segmented, Switching::by_clock}) {
    list.push_back(peer("Dormand-Prince 5(4)", solve<Dormand>, switching));
    list.push_back(peer("Fehlberg 7(8)", solve<Fehlberg>, switching));
    list.push_back(peer("Bulirsch-Stoer", solve<BulirschStoer>, switching));
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    list.push_back(peer("Dormand-Prince 5(4) AVX2", solve_avx2<Dormand>, Switching::segmented));
    list.push_back(peer("Fehlberg 7(8) AVX2", solve_avx2<Fehlberg>, Switching::segmented));
  }
  return list;
}

}  // namespace tribotrack::bench::peers
