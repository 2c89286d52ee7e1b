// What researchers use: Boost.odeint's controlled steppers on eq. (5), in extended precision as an
// independent reference, the paper's recipe, and Moreau-Jean.
#include "apps/bench/peers.h"

#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <optional>

#include "apps/bench/equation.h"

namespace tribotrack::bench {

using namespace model;

namespace {

namespace odeint = boost::numeric::odeint;

template <class T>
using State = typename PlainEquation<T>::State;

/// In units of A and A w, so that one tolerance serves both; the recipe's are m and m/s.
template <class T>
struct Slope {
  const PlainEquation<T>* f;
  T length = 1, speed = 1;
  std::optional<T> m = {};  ///< mu g of the segment; none: by the clock, and the part never sticks
  void operator()(const State<T>& q, State<T>& dqdt, T t) const {
    const State<T> d = f->slope(t, scaled(q, length, speed), m ? *m : f->friction(t), m.has_value());
    dqdt = scaled(d, 1 / length, 1 / speed);
  }
  static State<T> scaled(const State<T>& q, T x, T u) { return {q[0] * x, q[1] * x, q[2] * u, q[3] * u}; }
};

template <class Stepper>
struct Controlled {
  using T = typename Stepper::value_type;
  decltype(odeint::make_controlled<Stepper>(T(0), T(0))) stepper;
  /// odeint adds absolute and relative share: halves of both allow no more than the greater of them.
  explicit Controlled(T tolerance)
      : stepper(odeint::make_controlled<Stepper>(tolerance / 2, tolerance / 2)) {}
  Controlled(T tolerance, T max_step)
      : stepper(odeint::make_controlled<Stepper>(tolerance, tolerance, max_step)) {}
  void begin_segment() {
    if constexpr (requires { stepper.reset(); }) stepper.reset();
  }
};
struct BulirschStoer {
  odeint::bulirsch_stoer<State<double>> stepper;
  explicit BulirschStoer(double tolerance) : stepper(tolerance, tolerance) {}
  void begin_segment() { stepper.reset(); }
};
template <class T>
using DormandPrince = Controlled<odeint::runge_kutta_dopri5<State<T>, T, State<T>, T>>;
template <class T>
using Fehlberg = Controlled<odeint::runge_kutta_fehlberg78<State<T>, T, State<T>, T>>;

/// Steps to `until`; calls stopped() after each and ends early when it says so. Keeps the step size from
/// segment to segment.
template <class T, class Method, class Stopped>
void step_to(Method& method, const Slope<T>& slope, T until, T& h, Progress<T>& p, Stopped&& stopped) {
  method.begin_segment();
  State<T> q = Slope<T>::scaled(p.q, 1 / slope.length, 1 / slope.speed);
  while (p.t < until && p.within_budget()) {
    const T left = until - p.t;
    const bool last = h >= left * (1 - T(1e-12));
    T step = last ? left : h;
    const State<T> before = p.q;
    ++p.steps;
    if (method.stepper.try_step(slope, q, p.t, step) != odeint::success) {
      h = step;
      continue;
    }
    if (last) p.t = until;
    // A step cut short by the end of the segment says nothing against the longer one.
    h = last ? std::max(h, step) : step;
    p.q = Slope<T>::scaled(q, slope.length, slope.speed);
    if (stopped(before)) return;
  }
}

template <class T, class Method>
PeerResult solve(const Scenario& scenario, double tolerance, long max_steps) {
  const PlainEquation<T> f(scenario);
  const Scales scales(scenario);
  Method method{T(tolerance)};
  T h = T(1e-3) / f.frequency();
  Slope<T> slope{&f, T(scales.length), T(scales.speed)};
  const auto small = T(stop_speed(scales, tolerance));
  return run_in_segments(f, Progress<T>(scenario, max_steps), [&](Progress<T>& at, T until, T m) {
    slope.m = m;
    step_to(method, slope, until, h, at,
            [&](const State<T>& before) { return stops(f, before, m, small, at); });
  });
}

}  // namespace

PeerResult paper_recipe(const Scenario& scenario, double tolerance, double max_step, long max_steps) {
  const PlainEquation<double> f(scenario);
  DormandPrince<double> method(tolerance, max_step);
  double h = max_step;
  Progress<double> at(scenario, max_steps);
  step_to(method, Slope<double>{&f}, f.end(), h, at, [](const auto&) { return false; });
  return at.result(f.end());
}

PeerResult dormand_prince(const Scenario& scenario, double tolerance, long max_steps) {
  return solve<double, DormandPrince<double>>(scenario, tolerance, max_steps);
}

PeerResult extended_precision_reference(const Scenario& scenario, double tolerance) {
  return solve<long double, Fehlberg<long double>>(scenario, tolerance, 50'000'000);
}

PeerResult moreau_jean(const Scenario& scenario, double step) {
  const PlainEquation<double> f(scenario);
  const auto count = static_cast<long>(std::ceil(f.end() / step));
  const double h = f.end() / static_cast<double>(count);
  Eigen::Vector2d x = Eigen::Vector2d::Zero(), u = scenario.initial_velocity;
  for (long k = 0; k < count; ++k) {
    const double t = static_cast<double>(k + 1) * h;
    Eigen::Vector2d d;
    f.drive(t, d.x(), d.y());
    u += h * d;
    // What the friction impulse, at most h m, leaves of the free velocity.
    const double speed = u.norm(), impulse = h * f.friction(t);
    u *= speed > impulse ? 1 - impulse / speed : 0;
    x += h * u;
  }
  return {x, u, count, true};
}

std::vector<BenchPeer> library_peers() {
  std::vector<BenchPeer> peers{{"odeint Dormand-Prince 5(4)", dormand_prince},
                               {"odeint Fehlberg 7(8)", solve<double, Fehlberg<double>>},
                               {"odeint Bulirsch-Stoer", solve<double, BulirschStoer>}};
#ifdef TRIBOTRACK_HAS_CVODE
  for (BenchPeer& peer : cvode_peers()) peers.push_back(std::move(peer));
#endif
  return peers;
}

std::string missing_library() {
#ifdef TRIBOTRACK_HAS_CVODE
  return "";
#else
  return "SUNDIALS";
#endif
}

}  // namespace tribotrack::bench
