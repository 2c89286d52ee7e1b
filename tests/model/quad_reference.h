// The friction model in quadruple precision by another method than the product's: slow, obviously right.
//
// With d(sigma) = ds/|u| the equation u' = d - kappa u/|u| becomes du/dsigma = |u| d - kappa u, ds/dsigma =
// |u|: no division, no polar angles, one form for sliding, stopping and passing close to zero. It is solved
// by Gragg-Bulirsch-Stoer extrapolation of the midpoint rule; cos s and sin s ride along as unknowns. Edges
// are hit by Newton on the last step; a stop is |u| < 1e-26; starts from u = 0 begin a hair later on the
// known asymptote.
#pragma once

#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "model/quad_creep.h"
#include "model/quad_math.h"
#include "model/scenario.h"

namespace tribotrack::model::reference {

/// All parameters of a Scenario, in quadruple precision.
struct QuadScenario {
  std::array<quad, 15> value;  ///< by Parameter
  quad duration, cycles;
  explicit QuadScenario(const Scenario& s) : duration(s.duration), cycles(s.cycles) {
    for (int p = 0; p < 15; ++p) value[p] = s.get(static_cast<Parameter>(p));
  }
  quad& operator[](Parameter p) { return value[static_cast<int>(p)]; }
  quad operator[](Parameter p) const { return value[static_cast<int>(p)]; }
};

struct QuadState {
  quad ux = 0, uy = 0, x = 0, y = 0;  ///< m/s, m
  int stops = 0;
};

class QuadIntegrator {
 public:
  explicit QuadIntegrator(const QuadScenario& q, double tolerance = 1e-21) : tolerance_(tolerance) {
    w_ = q[Parameter::angular_frequency];
    const quad g = q[Parameter::gravity], a = q[Parameter::amplitude] * w_,
               b = q[Parameter::amplitude_y] * w_;
    quad st, ct;
    sine_cosine(q[Parameter::tilt_x], st, ct);
    gx_ = g * st / w_;
    sine_cosine(q[Parameter::tilt_y], st, ct);
    gy_ = g * st / w_;
    quad c, s, ce, se;
    sine_cosine(q[Parameter::start_phase], s, c);
    sine_cosine(q[Parameter::phase_shift], se, ce);
    px_ = a * c;
    qx_ = -a * s;
    py_ = b * (ce * c - se * s);
    qy_ = -b * (ce * s + se * c);
    nominal_ = q[Parameter::mu1] * g / w_;
    reduced_ = q[Parameter::mu2] * g / w_;
    unit_ = absolute(a) + absolute(b) + nominal_ + reduced_ + absolute(gx_) + absolute(gy_);
    if (!(unit_ > 0)) unit_ = absolute(q[Parameter::velocity_x]) + absolute(q[Parameter::velocity_y]);
    if (!(unit_ > 0)) unit_ = 1;
    for (quad* c_ : {&gx_, &gy_, &px_, &py_, &qx_, &qy_, &nominal_, &reduced_}) *c_ /= unit_;
    const quad turn = 2 * pi();
    const quad opening = q[Parameter::phi] + q[Parameter::lag] - q[Parameter::start_phase];
    opening_ = opening - turn * floor_of(opening / turn);
    // An opening meant to lie at the start must not be moved a whole turn away by the rounding of its angle.
    if (turn - opening_ < quad(1e-14)) opening_ = 0;
    width_ = q[Parameter::dtau];
    always_ = turn - width_ < quad(1e-15);
    ux_ = q[Parameter::velocity_x] / unit_;
    uy_ = q[Parameter::velocity_y] / unit_;
    end_ = q.duration > 0 ? q.duration * w_ : q.cycles * turn;
  }

  /// From the start to the end of the run.
  QuadState run(bool circling = false) {
    const quad turn = 2 * pi();
    std::vector<std::pair<quad, bool>> edges;
    for (quad n = -1; n * turn + opening_ < end_ && width_ > 0 && !always_; n += 1) {
      edges.emplace_back(opening_ + n * turn, true);
      edges.emplace_back(opening_ + width_ + n * turn, false);
    }
    bool open = always_;
    for (const auto& [at, opens] : edges) {
      if (at > end_) break;
      if (at > 0) {
        go(at, open ? reduced_ : nominal_);
      } else if (circling && at < 0) {
        continue;
      }
      open = opens;
    }
    go(end_, open ? reduced_ : nominal_);
    return {ux_ * unit_, uy_ * unit_, x_ * unit_ / w_, y_ * unit_ / w_, stops_};
  }

 private:
  // u, s - base, x, cos s, sin s
  using State = std::array<quad, 7>;

  State derivative(const State& y) const {
    const quad r = square_root(y[0] * y[0] + y[1] * y[1]);
    return {r * (gx_ + px_ * y[5] + qx_ * y[6]) - kappa_ * y[0],
            r * (gy_ + py_ * y[5] + qy_ * y[6]) - kappa_ * y[1],
            r,
            r * y[0],
            r * y[1],
            -y[6] * r,
            y[5] * r};
  }

  /// One extrapolated step; returns the error estimate. `easy`: converged with columns to spare.
  double step(const State& y, quad h, State& result, bool& easy) const {
    easy = false;
    constexpr int kColumns = 11;
    static thread_local std::array<State, kColumns> row, last;
    double error = HUGE_VAL;
    const State f0 = derivative(y);
    for (int j = 0; j < kColumns; ++j) {
      const int n = 2 * (j + 1);
      const quad small = h / n;
      State a = y, b;
      for (int i = 0; i < 7; ++i) b[i] = y[i] + small * f0[i];
      for (int m = 1; m < n; ++m) {
        const State f = derivative(b);
        for (int i = 0; i < 7; ++i) {
          const quad next = a[i] + 2 * small * f[i];
          a[i] = b[i];
          b[i] = next;
        }
      }
      const State f = derivative(b);
      row[0] = b;
      for (int i = 0; i < 7; ++i) row[0][i] = (a[i] + b[i] + small * f[i]) / 2;
      for (int k = 1; k <= j; ++k) {
        const quad ratio = quad(j + 1) / quad(j + 1 - k);
        for (int i = 0; i < 7; ++i)
          row[k][i] = row[k - 1][i] + (row[k - 1][i] - last[k - 1][i]) / (ratio * ratio - 1);
      }
      if (j > 0) {
        error = 0;
        for (int i = 0; i < 7; ++i)
          if (const double e = std::fabs(static_cast<double>(row[j][i] - row[j - 1][i])); !(e <= error)) {
            if (!(e < HUGE_VAL)) return HUGE_VAL;
            error = e;
          }
      }
      result = row[j];
      easy = j < kColumns - 2;
      if (error < tolerance_ * 0.01) return error;
      last = row;
    }
    return error;
  }

  quad excess(quad s) const {
    quad dx, dy;
    drive().at(s, dx, dy);
    return dx * dx + dy * dy - kappa_ * kappa_;
  }
  /// Half of its derivative.
  quad excess_slope(quad s) const {
    quad dx, dy, k, c;
    drive().at(s, dx, dy);
    sine_cosine(s, k, c);
    return dx * (qx_ * c - px_ * k) + dy * (qy_ * c - py_ * k);
  }
  QuadDrive drive() const { return {gx_, gy_, px_, py_, qx_, qy_}; }

  /// The first phase in [from, to] at which sign * excess grows through sign * level; `to` if none. A grid,
  /// and the peaks between its points: the excess has at most four extrema a cycle.
  quad crossing(quad from, quad to, quad level, int sign) const {
    const auto above = [&](quad s) { return sign * (excess(s) - level) > 0; };
    const auto climbs = [&](quad s) { return sign * excess_slope(s) > 0; };
    const auto bisect = [](quad low, quad high, auto&& beyond) {
      for (int i = 0; i < 110; ++i) {
        const quad middle = (low + high) / 2;
        (beyond(middle) ? high : low) = middle;
      }
      return high;
    };
    const quad grid = pi() / 200;
    for (quad low = from; low < to;) {
      const quad high = low + grid < to ? low + grid : to;
      if (above(high)) return bisect(low, high, above);
      if (climbs(low) && !climbs(high)) {
        const quad peak = bisect(low, high, [&](quad s) { return !climbs(s); });
        if (above(peak)) return bisect(low, peak, above);
      }
      low = high;
    }
    return to;
  }

  void go(quad target, quad kappa) {
    kappa_ = kappa;
    while (s_ < target) {
      if (absolute(ux_) + absolute(uy_) < quad(1e-26)) ux_ = uy_ = 0;
      if (ux_ == 0 && uy_ == 0)
        rest(target);
      else if (creep(target))
        continue;
      else
        slide(target);
    }
  }

  /// Slow, along the drive, and neither speeding up nor slowing down fast? Then over one long interval.
  bool creep(quad target) {
    const quad r = square_root(ux_ * ux_ + uy_ * uy_);
    if (!(kappa_ > 0) || r > quad(0.02) * kappa_) return false;
    if (steps_ < creep_again_) return false;
    quad dx, dy;
    drive().at(s_, dx, dy);
    if (r > 0 && absolute(ux_ * dy - uy_ * dx) > 5 * r * r) return false;
    const quad rate = (r > 0 ? (ux_ * dx + uy_ * dy) / r : square_root(dx * dx + dy * dy)) - kappa_;
    if (absolute(rate) > quad(0.05) * kappa_) return false;
    static const ChebyshevCreep chebyshev;
    quad h = target - s_ < quad(0.4) ? target - s_ : quad(0.4);
    // Where the drive falls below friction again the part may stop soon after: in small steps there.
    const quad falls = crossing(s_, s_ + h, 0, -1) - s_;
    if (rate > 0 && falls < h) h = falls / 2 > quad(1e-12) ? falls / 2 : h;
    if (rate < 0 && h * -rate > quad(0.9) * r) h = quad(0.9) * r / -rate;
    for (int i = 0; i < 9; ++i, h /= 3) {
      const auto end = chebyshev.over(drive(), kappa_, s_, h, ux_, uy_);
      if (!end) continue;
      ux_ = end->ux;
      uy_ = end->uy;
      x_ += end->dx;
      y_ += end->dy;
      s_ = h < target - s_ ? s_ + h : target;
      if (rate < 0 && square_root(ux_ * ux_ + uy_ * uy_) < quad(1e-26)) {
        ux_ = uy_ = 0;
        if (excess(s_) <= 0) ++stops_;
      }
      return true;
    }
    creep_again_ = steps_ + 200;
    return false;
  }

  /// Held until |d| grows through kappa, then off along the drive.
  void rest(quad target) {
    const quad rounding = quad(1e-15) * kappa_ * kappa_;
    if (excess(s_) <= rounding) {
      s_ = crossing(s_, target, rounding, 1);
      if (s_ >= target) return;
      take_off(target);
      return;
    }
    quad k, c;
    sine_cosine(s_, k, c);
    const quad dx = gx_ + px_ * c + qx_ * k, dy = gy_ + py_ * c + qy_ * k;
    const quad norm = square_root(dx * dx + dy * dy), surplus = norm - kappa_;
    if (creep(target)) return;
    const quad t = quad(1e-24) / surplus;
    ux_ = surplus * t * dx / norm;
    uy_ = surplus * t * dy / norm;
    s_ += t;
  }

  /// |d| grows smoothly through kappa at s: u = r n with the formal series of r n' = d - (d.n) n, r' = d.n -
  /// kappa.
  void take_off(quad target) {
    constexpr int kTerms = 40;
    quad k, c;
    sine_cosine(s_, k, c);
    std::array<quad, kTerms + 1> dx{}, dy{}, nx{}, ny{}, r{}, along{};
    dx[0] = gx_;
    dy[0] = gy_;
    quad a = c, b = k;
    for (int j = 0; j <= kTerms; ++j) {
      dx[j] += px_ * a + qx_ * b;
      dy[j] += py_ * a + qy_ * b;
      const quad next = -b / (j + 1);
      b = a / (j + 1);
      a = next;
    }
    nx[0] = dx[0] / kappa_;
    ny[0] = dy[0] / kappa_;
    along[0] = kappa_;
    for (int j = 1; j < kTerms; ++j) {
      r[j] = j == 1 ? quad(0) : along[j - 1] / j;
      // d_j - lower terms of (d.n) n - (r n')_j, across n0; then |n| = 1 gives the part along n0.
      quad ax = dx[j], ay = dy[j];
      for (int i = 1; i < j; ++i) {
        ax -= along[i] * nx[j - i];
        ay -= along[i] * ny[j - i];
      }
      for (int i = 2; i <= j; ++i) {
        ax -= r[i] * (j - i + 1) * nx[j - i + 1];
        ay -= r[i] * (j - i + 1) * ny[j - i + 1];
      }
      const quad across = (ay * nx[0] - ax * ny[0]) / kappa_;
      quad inward = 0;
      for (int i = 1; i < j; ++i) inward -= (nx[i] * nx[j - i] + ny[i] * ny[j - i]) / 2;
      nx[j] = -across * ny[0] + inward * nx[0];
      ny[j] = across * nx[0] + inward * ny[0];
      along[j] = 0;
      for (int i = 0; i <= j; ++i) along[j] += dx[i] * nx[j - i] + dy[i] * ny[j - i];
    }
    const auto sum = [](const auto& f, quad t, int terms) {
      quad total = 0;
      for (int j = terms; j >= 0; --j) total = total * t + f[j];
      return total;
    };
    // The series is asymptotic: go as far as its terms have fallen to rounding.
    quad t = 1;
    constexpr int kLast = kTerms - 2;
    const auto negligible = [&](quad at) {
      quad power = 1;
      for (int j = 0; j < kLast; ++j) power *= at;
      return absolute(nx[kLast] * power) + absolute(ny[kLast] * power) < quad(1e-27);
    };
    while (!negligible(t)) t /= quad(1.25);
    // Not as far as to where the drive falls below friction again: the part may stop there.
    const quad falls = crossing(s_ + quad(1e-9), s_ + t, 0, -1) - s_;
    if (falls < t) t = falls / 4;
    if (s_ + t > target) t = target - s_;
    // position by Simpson-free exact integration of the product series
    std::array<quad, kTerms + 1> vx{}, vy{};
    for (int j = 0; j <= kLast; ++j)
      for (int i = 0; i <= j; ++i) {
        vx[j] += r[i] * nx[j - i];
        vy[j] += r[i] * ny[j - i];
      }
    ux_ = sum(vx, t, kLast);
    uy_ = sum(vy, t, kLast);
    for (int j = 0; j <= kLast; ++j) {
      vx[j] /= j + 1;
      vy[j] /= j + 1;
    }
    x_ += t * sum(vx, t, kLast);
    y_ += t * sum(vy, t, kLast);
    s_ += t;
  }

  void slide(quad target) {
    quad k, c;
    sine_cosine(s_, k, c);
    State y{ux_, uy_, 0, x_, y_, c, k}, next;
    const quad base = s_, floor = quad(1e-26);
    // Directions and speeds change over sigma ~ 1/(|d| + kappa), whatever the units.
    quad dx, dy;
    drive().at(s_, dx, dy);
    const quad longest = quad(1.5) / (square_root(dx * dx + dy * dy) + kappa_);
    quad h = step_ < longest ? step_ : longest;
    bool stopped = false, easy = false;
    for (long count = 0;; ++count) {
      if (++steps_ > patience_) throw std::runtime_error("reference: too many steps");
      const double error = step(y, h, next, easy);
      if (error > tolerance_) {
        h /= 2;
        continue;
      }
      if (base + next[2] >= target) {
        for (int i = 0; i < 60; ++i) {  // the length of the last step
          const quad miss = target - base - next[2];
          const quad r = square_root(next[0] * next[0] + next[1] * next[1]);
          if (absolute(miss) < quad(1e-30) || absolute(miss) < quad(1e-28) * absolute(r)) break;
          h += miss / r;
          step(y, h, next, easy);
        }
        y = next;
        s_ = target;
        break;
      }
      y = next;
      if (y[0] * y[0] + y[1] * y[1] < floor * floor) {
        stopped = true;
        s_ = base + y[2];
        break;
      }
      if (easy && h < longest) h *= quad(1.5);
      step_ = h;
      if (count % 40 == 39) {  // back to the caller, which may find that it creeps
        s_ = base + y[2];
        break;
      }
    }
    x_ = y[3];
    y_ = y[4];
    ux_ = stopped ? quad(0) : y[0];
    uy_ = stopped ? quad(0) : y[1];
    if (stopped && excess(s_) <= 0) ++stops_;
  }

  double tolerance_;
  long steps_ = 0, patience_ = 60000, creep_again_ = 0;
  quad step_ = 0.25;
  quad w_, unit_, gx_, gy_, px_, py_, qx_, qy_, nominal_, reduced_, kappa_ = 0;
  quad opening_, width_, end_;
  bool always_ = false;
  quad ux_ = 0, uy_ = 0, x_ = 0, y_ = 0, s_ = 0;
  int stops_ = 0;
};

inline QuadState integrate(const QuadScenario& q) {
  return QuadIntegrator(q).run();
}

}  // namespace tribotrack::model::reference
