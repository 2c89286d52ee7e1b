// Dormand-Prince 5(4) on eq. (5), as others integrate it: for comparison, and in extended precision as an
// independent reference. Shares nothing with the library's own integrator.
//
// Source of the coefficients: Dormand & Prince, J. Comp. Appl. Math. 6 (1980); Hairer, Norsett, Wanner,
// "Solving Ordinary Differential Equations I", table II.5.2.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "apps/bench/peers/baselines.h"

namespace tribotrack::bench {

/// Eq. (5) in a floating-point type: state (x, y, u_x, u_y).
template <class T>
class PlainEquation {
 public:
  using State = std::array<T, 4>;

  explicit PlainEquation(const model::Scenario& s)
      : w_(s.drive.angular_frequency),
        start_phase_(s.start_phase),
        ax_(T(s.drive.amplitude) * w_ * w_),
        ay_cos_(T(s.drive.amplitude_y) * w_ * w_ * std::cos(T(s.drive.phase_shift))),
        ay_sin_(T(s.drive.amplitude_y) * w_ * w_ * std::sin(T(s.drive.phase_shift))),
        tilt_x_(T(s.drive.gravity) * std::sin(T(s.drive.tilt_x))),
        tilt_y_(T(s.drive.gravity) * std::sin(T(s.drive.tilt_y))),
        m1_(T(s.friction.nominal) * T(s.drive.gravity)),
        m2_(T(s.friction.reduced) * T(s.drive.gravity)),
        opens_(T(s.friction.phase) + T(s.friction.lag)),
        width_(s.friction.pulse_width),
        end_(s.duration > 0 ? T(s.duration) : T(s.cycles) * turn() / w_) {}

  T end() const { return end_; }
  T frequency() const { return w_; }
  /// mu g at a time.
  T friction(T t) const {
    T into = std::fmod(start_phase_ + w_ * t - opens_, turn());
    if (into < 0) into += turn();
    return into < width_ ? m2_ : m1_;
  }
  void drive(T t, T& x, T& y) const {
    const T c = std::cos(start_phase_ + w_ * t), s = std::sin(start_phase_ + w_ * t);
    x = ax_ * c + tilt_x_;
    y = ay_cos_ * c - ay_sin_ * s + tilt_y_;
  }
  T drive_size(T t) const {
    T x, y;
    drive(t, x, y);
    return std::hypot(x, y);
  }
  /// u' = d - m u / |u|. At u = 0 friction is nothing (as the recipe has it) or opposes the drive.
  State slope(T t, const State& q, T m, bool opposes_drive_at_rest) const {
    T dx, dy;
    drive(t, dx, dy);
    const T speed = std::sqrt(q[2] * q[2] + q[3] * q[3]);
    if (speed > 0) {
      const T f = m / speed;
      return {q[2], q[3], dx - f * q[2], dy - f * q[3]};
    }
    const T size = opposes_drive_at_rest ? std::sqrt(dx * dx + dy * dy) : T(0);
    const T left = size > 0 ? std::max(T(0), 1 - m / size) : T(1);
    return {q[2], q[3], dx * left, dy * left};
  }
  /// Times of the friction switches inside the run, then its end.
  std::vector<T> stations() const {
    std::vector<T> times;
    if (width_ > 0 && width_ < turn())
      for (const T edge : {opens_, opens_ + width_}) {
        const T offset = edge - start_phase_;
        for (T n = std::floor(-offset / turn());; n += 1) {
          const T t = (offset + n * turn()) / w_;
          if (t >= end_) break;
          if (t > 0) times.push_back(t);
        }
      }
    times.push_back(end_);
    std::sort(times.begin(), times.end());
    return times;
  }
  /// First time in [t, last] at which the drive exceeds m; `last` where it never does.
  T release(T t, T last, T m) const {
    const T step = turn() / w_ / 720;
    for (T before = t; before < last; before += step) {
      T after = std::min(before + step, last);
      if (drive_size(before) > m) return before;
      if (drive_size(after) <= m) continue;
      while (after - before > std::numeric_limits<T>::epsilon() * last * 4) {
        const T middle = (before + after) / 2;
        (drive_size(middle) > m ? after : before) = middle;
      }
      return after;
    }
    return last;
  }

  static T turn() { return 2 * std::numbers::pi_v<T>; }

 private:
  T w_, start_phase_, ax_, ay_cos_, ay_sin_, tilt_x_, tilt_y_, m1_, m2_, opens_, width_, end_;
};

template <class T>
class DormandPrince {
 public:
  using State = typename PlainEquation<T>::State;

  DormandPrince(const model::Scenario& scenario, const DormandPrinceOptions& options)
      : f_(scenario),
        options_(options),
        q_{0, 0, T(scenario.initial_velocity.x()), T(scenario.initial_velocity.y())} {}

  PeerResult run() {
    if (options_.segmented) {
      for (const T station : f_.stations()) {
        // Inside a segment mu is constant: its value at the middle is free of rounding at the edges.
        m_ = f_.friction((t_ + station) / 2);
        while (t_ < station && within_budget()) {
          if (at_rest()) t_ = f_.release(t_, station, m_);
          if (t_ < station) slide_to(station);
        }
      }
    } else {
      slide_to(f_.end());
    }
    PeerResult result;
    result.position = {static_cast<double>(q_[0]), static_cast<double>(q_[1])};
    result.velocity = {static_cast<double>(q_[2]), static_cast<double>(q_[3])};
    result.steps = steps_;
    result.finished = t_ >= f_.end();
    return result;
  }

 private:
  bool within_budget() const { return steps_ < options_.max_steps; }
  bool at_rest() const { return q_[2] == 0 && q_[3] == 0; }
  T friction(T t) const { return options_.segmented ? m_ : f_.friction(t); }
  State slope(T t, const State& q) const { return f_.slope(t, q, friction(t), options_.segmented); }

  static State plus(const State& q, T h, std::initializer_list<std::pair<T, const State*>> terms) {
    State r = q;
    for (const auto& [weight, k] : terms)
      for (std::size_t i = 0; i < 4; ++i) r[i] += h * weight * (*k)[i];
    return r;
  }

  /// Until `last`, or until the part stops (segmented only).
  void slide_to(T last) {
    State k1 = slope(t_, q_);
    T h = h_ > 0 ? std::min(h_, last - t_) : T(1e-3) / f_.frequency();
    while (t_ < last && within_budget()) {
      if (options_.max_step > 0) h = std::min(h, T(options_.max_step));
      const bool ends = t_ + h >= last || last - t_ - h < T(1e-3) * h;
      if (ends) h = last - t_;
      const State k2 = slope(t_ + h / 5, plus(q_, h, {{T(1) / 5, &k1}}));
      const State k3 = slope(t_ + 3 * h / 10, plus(q_, h, {{T(3) / 40, &k1}, {T(9) / 40, &k2}}));
      const State k4 =
          slope(t_ + 4 * h / 5, plus(q_, h, {{T(44) / 45, &k1}, {T(-56) / 15, &k2}, {T(32) / 9, &k3}}));
      const State k5 = slope(t_ + 8 * h / 9, plus(q_, h,
                                                  {{T(19372) / 6561, &k1},
                                                   {T(-25360) / 2187, &k2},
                                                   {T(64448) / 6561, &k3},
                                                   {T(-212) / 729, &k4}}));
      const State k6 = slope(t_ + h, plus(q_, h,
                                          {{T(9017) / 3168, &k1},
                                           {T(-355) / 33, &k2},
                                           {T(46732) / 5247, &k3},
                                           {T(49) / 176, &k4},
                                           {T(-5103) / 18656, &k5}}));
      const State next = plus(q_, h,
                              {{T(35) / 384, &k1},
                               {T(500) / 1113, &k3},
                               {T(125) / 192, &k4},
                               {T(-2187) / 6784, &k5},
                               {T(11) / 84, &k6}});
      const State k7 = slope(t_ + h, next);
      const State error = plus({0, 0, 0, 0}, h,
                               {{T(71) / 57600, &k1},
                                {T(-71) / 16695, &k3},
                                {T(71) / 1920, &k4},
                                {T(-17253) / 339200, &k5},
                                {T(22) / 525, &k6},
                                {T(-1) / 40, &k7}});
      const T size = error_size(error, next);
      ++steps_;
      const T factor = size > 0 ? T(0.9) * std::pow(size, T(-0.2)) : T(5);
      if (!(size <= 1)) {
        h *= std::isfinite(size) ? std::clamp(factor, T(0.1), T(0.9)) : T(0.1);
        continue;
      }
      const State before = q_;
      q_ = next;
      t_ = ends ? last : t_ + h;
      k1 = k7;
      if (!ends) h_ = h;
      h *= std::clamp(factor, T(0.2), T(5));
      if (options_.segmented && stops(before)) return;
    }
  }

  T error_size(const State& error, const State& next) const {
    T size = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const T absolute = T(i < 2 ? options_.position_tolerance : options_.velocity_tolerance);
      const T relative = T(options_.relative_tolerance) * std::max(std::abs(q_[i]), std::abs(next[i]));
      const T ratio = std::abs(error[i]) / std::max(absolute, relative);
      if (!(ratio <= size)) size = ratio;  // keeps NaN
    }
    return size;
  }

  /// The witness of a stop: friction exceeds the drive and the velocity has turned round or is below
  /// stop_speed.
  bool stops(const State& before) {
    const T turned = before[2] * q_[2] + before[3] * q_[3];
    const T speed = std::hypot(q_[2], q_[3]);
    if (turned > 0 && speed > T(options_.stop_speed)) return false;
    if (f_.drive_size(t_) > m_) return false;
    q_[2] = q_[3] = 0;
    return true;
  }

  PlainEquation<T> f_;
  DormandPrinceOptions options_;
  State q_;
  T t_ = 0, m_ = 0, h_ = 0;
  long steps_ = 0;
};

}  // namespace tribotrack::bench
