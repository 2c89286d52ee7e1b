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
#include "model/quad_drive.h"
#include "model/quad_math.h"
#include "model/quad_scenario.h"
#include "model/quad_take_off.h"
#include "model/scenario.h"

namespace tribotrack::model::reference {

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
    drive_.constant_x = g * st / w_;
    sine_cosine(q[Parameter::tilt_y], st, ct);
    drive_.constant_y = g * st / w_;
    quad c, s, ce, se;
    sine_cosine(q[Parameter::start_phase], s, c);
    sine_cosine(q[Parameter::phase_shift], se, ce);
    drive_.px = a * c;
    drive_.qx = -a * s;
    drive_.py = b * (ce * c - se * s);
    drive_.qy = -b * (ce * s + se * c);
    nominal_ = q[Parameter::mu1] * g / w_;
    reduced_ = q[Parameter::mu2] * g / w_;
    unit_ = absolute(a) + absolute(b) + nominal_ + reduced_ + absolute(drive_.constant_x) +
            absolute(drive_.constant_y);
    if (!(unit_ > 0)) unit_ = absolute(q[Parameter::velocity_x]) + absolute(q[Parameter::velocity_y]);
    if (!(unit_ > 0)) unit_ = 1;
    for (quad* c_ : {&drive_.constant_x, &drive_.constant_y, &drive_.px, &drive_.py, &drive_.qx, &drive_.qy,
                     &nominal_, &reduced_})
      *c_ /= unit_;
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
    return {r * (drive_.constant_x + drive_.px * y[5] + drive_.qx * y[6]) - kappa_ * y[0],
            r * (drive_.constant_y + drive_.py * y[5] + drive_.qy * y[6]) - kappa_ * y[1],
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

  quad excess(quad s) const { return drive_.excess(s, kappa_); }

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

  void follow(const QuadStretch& stretch) {
    ux_ = stretch.end.ux;
    uy_ = stretch.end.uy;
    x_ += stretch.end.dx;
    y_ += stretch.end.dy;
    s_ += stretch.span;
  }

  /// Slow, along the drive, and neither speeding up nor slowing down fast? Then over one long interval.
  bool creep(quad target) {
    const quad r = square_root(ux_ * ux_ + uy_ * uy_);
    if (!(kappa_ > 0) || r > quad(0.02) * kappa_) return false;
    if (steps_ < creep_again_) return false;
    quad dx, dy;
    drive_.at(s_, dx, dy);
    if (r > 0 && absolute(ux_ * dy - uy_ * dx) > 5 * r * r) return false;
    const quad rate = (r > 0 ? (ux_ * dx + uy_ * dy) / r : square_root(dx * dx + dy * dy)) - kappa_;
    if (absolute(rate) > quad(0.05) * kappa_) return false;
    static const ChebyshevCreep chebyshev;
    quad h = target - s_ < quad(0.4) ? target - s_ : quad(0.4);
    // Where the drive falls below friction again the part may stop soon after: in small steps there.
    const quad falls = drive_.crossing(kappa_, s_, s_ + h, 0, -1) - s_;
    if (rate > 0 && falls < h) h = falls / 2 > quad(1e-12) ? falls / 2 : h;
    if (rate < 0 && h * -rate > quad(0.9) * r) h = quad(0.9) * r / -rate;
    for (int i = 0; i < 9; ++i, h /= 3) {
      const auto end = chebyshev.over(drive_, kappa_, s_, h, ux_, uy_);
      if (!end) continue;
      follow({*end, h});
      if (target - s_ < quad(1e-30)) s_ = target;
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
      s_ = drive_.crossing(kappa_, s_, target, rounding, 1);
      if (s_ >= target) return;
      follow(take_off(drive_, kappa_, s_, target));
      return;
    }
    quad dx, dy;
    drive_.at(s_, dx, dy);
    const quad norm = square_root(dx * dx + dy * dy), surplus = norm - kappa_;
    if (creep(target)) return;
    const quad t = quad(1e-24) / surplus;
    ux_ = surplus * t * dx / norm;
    uy_ = surplus * t * dy / norm;
    s_ += t;
  }

  void slide(quad target) {
    quad k, c;
    sine_cosine(s_, k, c);
    State y{ux_, uy_, 0, x_, y_, c, k}, next;
    const quad base = s_, floor = quad(1e-26);
    // Directions and speeds change over sigma ~ 1/(|d| + kappa), whatever the units.
    quad dx, dy;
    drive_.at(s_, dx, dy);
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
  QuadDrive drive_;
  quad w_, unit_, nominal_, reduced_, kappa_ = 0;
  quad opening_, width_, end_;
  bool always_ = false;
  quad ux_ = 0, uy_ = 0, x_ = 0, y_ = 0, s_ = 0;
  int stops_ = 0;
};

inline QuadState integrate(const QuadScenario& q) {
  return QuadIntegrator(q).run();
}

}  // namespace tribotrack::model::reference
