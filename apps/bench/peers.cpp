// Own compact versions of what researchers use, so that all are compiled alike: Dormand-Prince 5(4), in
// extended precision as an independent reference, and Moreau-Jean.
//
// Source of the coefficients: Dormand & Prince, J. Comp. Appl. Math. 6 (1980); Hairer, Norsett, Wanner,
// "Solving Ordinary Differential Equations I", table II.5.2.
#include "apps/bench/peers.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "apps/bench/equation.h"

namespace tribotrack::bench {

using namespace model;

namespace {

void check(const Scenario& scenario) {
  scenario.validate();
  if (scenario.start != Start::rest)
    throw std::invalid_argument("the peers integrate from rest or an initial velocity only");
}

template <class T>
class DormandPrince {
 public:
  using State = typename PlainEquation<T>::State;

  DormandPrince(const Scenario& scenario, const DormandPrinceOptions& options)
      : f_(scenario), options_(options), start_(scenario, options.max_steps) {}

  PeerResult run() {
    if (options_.segmented)
      return run_in_segments(f_, start_, [this](Progress<T>& p, T until, T m) {
        m_ = m;
        slide_to(until, p);
      });
    Progress<T> p = start_;
    slide_to(f_.end(), p);
    return p.result(f_.end());
  }

 private:
  T friction(T t) const { return options_.segmented ? m_ : f_.friction(t); }
  State slope(T t, const State& q) const { return f_.slope(t, q, friction(t), options_.segmented); }

  static State plus(const State& q, T h, std::initializer_list<std::pair<T, const State*>> terms) {
    State r = q;
    for (const auto& [weight, k] : terms)
      for (std::size_t i = 0; i < 4; ++i) r[i] += h * weight * (*k)[i];
    return r;
  }

  /// Until `last`, or until the part stops (segmented only).
  void slide_to(T last, Progress<T>& p) {
    State k1 = slope(p.t, p.q);
    T h = h_ > 0 ? std::min(h_, last - p.t) : T(1e-3) / f_.frequency();
    while (p.t < last && p.within_budget()) {
      if (options_.max_step > 0) h = std::min(h, T(options_.max_step));
      const bool ends = p.t + h >= last || last - p.t - h < T(1e-3) * h;
      if (ends) h = last - p.t;
      const State k2 = slope(p.t + h / 5, plus(p.q, h, {{T(1) / 5, &k1}}));
      const State k3 = slope(p.t + 3 * h / 10, plus(p.q, h, {{T(3) / 40, &k1}, {T(9) / 40, &k2}}));
      const State k4 =
          slope(p.t + 4 * h / 5, plus(p.q, h, {{T(44) / 45, &k1}, {T(-56) / 15, &k2}, {T(32) / 9, &k3}}));
      const State k5 = slope(p.t + 8 * h / 9, plus(p.q, h,
                                                   {{T(19372) / 6561, &k1},
                                                    {T(-25360) / 2187, &k2},
                                                    {T(64448) / 6561, &k3},
                                                    {T(-212) / 729, &k4}}));
      const State k6 = slope(p.t + h, plus(p.q, h,
                                           {{T(9017) / 3168, &k1},
                                            {T(-355) / 33, &k2},
                                            {T(46732) / 5247, &k3},
                                            {T(49) / 176, &k4},
                                            {T(-5103) / 18656, &k5}}));
      const State next = plus(p.q, h,
                              {{T(35) / 384, &k1},
                               {T(500) / 1113, &k3},
                               {T(125) / 192, &k4},
                               {T(-2187) / 6784, &k5},
                               {T(11) / 84, &k6}});
      const State k7 = slope(p.t + h, next);
      const State error = plus({0, 0, 0, 0}, h,
                               {{T(71) / 57600, &k1},
                                {T(-71) / 16695, &k3},
                                {T(71) / 1920, &k4},
                                {T(-17253) / 339200, &k5},
                                {T(22) / 525, &k6},
                                {T(-1) / 40, &k7}});
      const T size = error_size(error, p.q, next);
      ++p.steps;
      const T factor = size > 0 ? T(0.9) * std::pow(size, T(-0.2)) : T(5);
      if (!(size <= 1)) {
        h *= std::isfinite(size) ? std::clamp(factor, T(0.1), T(0.9)) : T(0.1);
        continue;
      }
      const State before = p.q;
      p.q = next;
      p.t = ends ? last : p.t + h;
      k1 = k7;
      if (!ends) h_ = h;
      h *= std::clamp(factor, T(0.2), T(5));
      if (options_.segmented && stops(f_, before, m_, T(options_.stop_speed), p)) return;
    }
  }

  T error_size(const State& error, const State& q, const State& next) const {
    T size = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const T absolute = T(i < 2 ? options_.position_tolerance : options_.velocity_tolerance);
      const T relative = T(options_.relative_tolerance) * std::max(std::abs(q[i]), std::abs(next[i]));
      const T ratio = std::abs(error[i]) / std::max(absolute, relative);
      if (!(ratio <= size)) size = ratio;  // keeps NaN
    }
    return size;
  }

  PlainEquation<T> f_;
  DormandPrinceOptions options_;
  Progress<T> start_;
  T m_ = 0, h_ = 0;
};

}  // namespace

DormandPrinceOptions paper_recipe() {
  DormandPrinceOptions options;
  options.max_step = 1e-4;
  return options;
}

DormandPrinceOptions segmented_dormand_prince(const Scenario& scenario, double tolerance) {
  const Scales scales(scenario);
  DormandPrinceOptions options;
  options.relative_tolerance = tolerance;
  options.position_tolerance = tolerance * scales.length;
  options.velocity_tolerance = tolerance * scales.length * scenario.drive.angular_frequency;
  options.segmented = true;
  options.stop_speed = std::max(30 * tolerance, 1e-10) * scales.length * scenario.drive.angular_frequency;
  return options;
}

PeerResult dormand_prince(const Scenario& scenario, const DormandPrinceOptions& options) {
  check(scenario);
  return DormandPrince<double>(scenario, options).run();
}

PeerResult extended_precision_reference(const Scenario& scenario, double tolerance) {
  check(scenario);
  DormandPrinceOptions options = segmented_dormand_prince(scenario, tolerance);
  options.max_steps = 50'000'000;
  return DormandPrince<long double>(scenario, options).run();
}

PeerResult moreau_jean(const Scenario& scenario, double step) {
  check(scenario);
  const PlainEquation<double> f(scenario);
  const auto count = static_cast<long>(std::ceil(f.end() / step));
  const double h = f.end() / static_cast<double>(count);
  PeerResult result;
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
  result.position = x;
  result.velocity = u;
  result.steps = count;
  result.finished = true;
  return result;
}

std::vector<BenchPeer> library_peers() {
  std::vector<BenchPeer> peers;
  [[maybe_unused]] const auto add = [&](std::vector<BenchPeer> more) {
    for (BenchPeer& peer : more) peers.push_back(std::move(peer));
  };
#ifdef TRIBOTRACK_HAS_ODEINT
  add(odeint_peers());
#endif
#ifdef TRIBOTRACK_HAS_CVODE
  add(cvode_peers());
#endif
  return peers;
}

std::vector<std::string> missing_libraries() {
  std::vector<std::string> missing;
#ifndef TRIBOTRACK_HAS_ODEINT
  missing.emplace_back("Boost.odeint");
#endif
#ifndef TRIBOTRACK_HAS_CVODE
  missing.emplace_back("SUNDIALS");
#endif
  return missing;
}

}  // namespace tribotrack::bench
