// Steps of SlideLanes, for whichever instruction set the including file is compiled for.
#pragma once

#include <cstdint>

#include "model/lanes/slide_lanes.h"
#include "model/processor/lanes.h"

namespace tribotrack::model::internal {

/// Taylor series of order N = 16: at the tolerances of interest the cost per phase has a wide minimum about
/// there. L lanes at once.
template <class Set, int L>
struct SlideKernel {
  static constexpr int N = 16;
  /// Where a motion has settled its coefficients do not show how fast neighbours settle (rates up to kappa/r
  /// in t, kappa + 1 in sigma): exp(-x) is within 4e-10 of its Taylor polynomial up to here.
  static constexpr double kDampedStep = 2;
  using V = Lanes<L>;
  typedef std::int64_t Bits __attribute__((vector_size(8 * L)));
  using Math = LaneMath<Set, L>;

  [[gnu::always_inline]] static V load(const double* p) { return Math::load(p); }
  [[gnu::always_inline]] static void store(const V& v, double* p) { Math::store(v, p); }
  [[gnu::always_inline]] static V abs(const V& v) { return (V)((Bits)v & 0x7fffffffffffffffll); }
  [[gnu::always_inline]] static V max(const V& a, const V& b) { return a > b ? a : b; }
  [[gnu::always_inline]] static V min(const V& a, const V& b) { return a < b ? a : b; }

  /// log2 and its inverse to 0.09, from the bits of the number.
  [[gnu::always_inline]] static V rough_log2(const V& v) {
    return __builtin_convertvector((Bits)v, V) * 0x1p-52 - 1023.0;
  }
  [[gnu::always_inline]] static V rough_exp2(const V& v) {
    return (V) __builtin_convertvector((v + 1023.0) * 0x1p52, Bits);
  }
  /// The step over which the terms N and N - 1 of v and z come down to the tolerance (Jorba & Zou 2005, eq.
  /// 3-8).
  [[gnu::always_inline]] static V step(const V& tolerance, const V* vx, const V* vy, const V* zx,
                                       const V* zy) {
    const auto largest = [&](int k) { return max(max(abs(vx[k]), abs(vy[k])), max(abs(zx[k]), abs(zy[k]))); };
    const V allowed = rough_log2(tolerance);
    const V a = (allowed - rough_log2(largest(N))) * (1.0 / N);
    const V b = (allowed - rough_log2(largest(N - 1))) * (1.0 / (N - 1));
    return rough_exp2(min(min(a, b), 10.0 + V{}));
  }

  [[gnu::always_inline]] static V horner(const V* c, int order, const V& t) {
    V sum = c[order];
#pragma GCC unroll 32
    for (int k = order - 1; k >= 0; --k) sum = sum * t + c[k];
    return sum;
  }

  /// sum of a_j b_(k-j), j = first .. last
  [[gnu::always_inline]] static V product(const V* a, const V* b, int k, int first, int last) {
    V sum{};
#pragma GCC unroll 32
    for (int j = first; j <= last; ++j) sum += a[j] * b[k - j];
    return sum;
  }

  template <void (*kStep)(SlideLanes&, int)>
  static void all(SlideLanes& lanes) {
    for (int at = 0; at < SlideLanes::kWidth; at += L) kStep(lanes, at);
  }
  static SlideMachines machines() {
    return {all<start>, {all<slide<false>>, all<slide<true>>}, {all<creep<false>>, all<creep<true>>}};
  }

  /// The motion as series in time: n from r n = v.
  struct Series {
    V vx[N + 1], vy[N + 1], zx[N + 1], zy[N + 1], r[N + 1], nx[N], ny[N];
  };

  template <bool kNeighbours>
  static void slide(SlideLanes& g, int at) {
    const V kappa = load(g.kappa + at), left = load(g.left + at);
    Series s;
    s.vx[0] = load(g.vx + at);
    s.vy[0] = load(g.vy + at);
    s.zx[0] = load(g.zx + at);
    s.zy[0] = load(g.zy + at);
    s.r[0] = Math::sqrt(s.vx[0] * s.vx[0] + s.vy[0] * s.vy[0]);
    const V inverse = 1.0 / s.r[0];
    s.nx[0] = s.vx[0] * inverse;
    s.ny[0] = s.vy[0] * inverse;
#pragma GCC unroll 32
    for (int k = 0; k < N; ++k) {
      const double share = 1.0 / (k + 1);
      s.vx[k + 1] = ((k == 0 ? 1.0 + s.vy[0] : s.vy[k]) - kappa * s.nx[k]) * share;
      s.vy[k + 1] = (-s.vx[k] - kappa * s.ny[k]) * share;
      s.zx[k + 1] = (s.vx[k] + s.zy[k]) * share;
      s.zy[k + 1] = (s.vy[k] - s.zx[k]) * share;
      s.r[k + 1] = k == 0 ? s.nx[0] - kappa : s.nx[k] * share;
      if (k + 1 == N) break;
      V x = s.vx[k + 1] - s.r[k + 1] * s.nx[0], y = s.vy[k + 1] - s.r[k + 1] * s.ny[0];
      if (k > 0) {
        x -= product(s.r, s.nx, k + 1, 1, k);
        y -= product(s.r, s.ny, k + 1, 1, k);
      }
      s.nx[k + 1] = x * inverse;
      s.ny[k + 1] = y * inverse;
    }
    const V damped = min(kDampedStep * s.r[0] / kappa, kDampedStep + V{});
    const V h = min(left, min(damped, step(load(g.tolerance + at), s.vx, s.vy, s.zx, s.zy)));
    const V vx = horner(s.vx, N, h), vy = horner(s.vy, N, h);
    store(vx, g.vx + at);
    store(vy, g.vy + at);
    store(horner(s.zx, N, h), g.zx + at);
    store(horner(s.zy, N, h), g.zy + at);
    store(left - h, g.left + at);
    if constexpr (kNeighbours) {
      Node node[2];
      for (int i = 0; i < 2; ++i) {
        const V t = h * kGauss[i];
        const V x = horner(s.vx, N, t), y = horner(s.vy, N, t), square = 1.0 / (x * x + y * y);
        node[i] = {y * square, kappa * Math::sqrt(square)};
      }
      const V speed = Math::sqrt(vx * vx + vy * vy), pace = 1.0 / speed, one = V{} + 1.0;
      const Edge before{s.nx[0], s.ny[0], one, V{}, kappa * inverse};
      const Edge after{vx * pace, vy * pace, one, V{}, kappa * pace};
      Neighbours(g, at).carry(h, node, before, after, h, g, at);
    }
  }

  /// In sigma no division is left: with m = r v,
  ///   v' = r - kappa v - i m,   r' = v_x - kappa r,   z' = m - i r z,   t' = r.
  template <bool kNeighbours>
  static void creep(SlideLanes& g, int at) {
    const V kappa = load(g.kappa + at), left = load(g.left + at);
    V vx[N + 1], vy[N + 1], zx[N + 1], zy[N + 1], r[N + 1], t[N + 1];
    vx[0] = load(g.vx + at);
    vy[0] = load(g.vy + at);
    zx[0] = load(g.zx + at);
    zy[0] = load(g.zy + at);
    r[0] = Math::sqrt(vx[0] * vx[0] + vy[0] * vy[0]);
    t[0] = V{};
#pragma GCC unroll 32
    for (int k = 0; k < N; ++k) {
      const double share = 1.0 / (k + 1);
      const V mx = product(r, vx, k, 0, k), my = product(r, vy, k, 0, k);
      const V rx = product(r, zx, k, 0, k), ry = product(r, zy, k, 0, k);
      vx[k + 1] = (r[k] - kappa * vx[k] + my) * share;
      vy[k + 1] = (-kappa * vy[k] - mx) * share;
      zx[k + 1] = (mx + ry) * share;
      zy[k + 1] = (my - rx) * share;
      t[k + 1] = r[k] * share;
      r[k + 1] = (vx[k] - kappa * r[k]) * share;
    }
    V h = min(step(load(g.tolerance + at), vx, vy, zx, zy), kDampedStep / (kappa + 1.0));
    const V gone = horner(t, N, h);
    const auto too_far = gone > left;
    h = too_far ? V{} : h;
    store(too_far ? -left : left - gone, g.left + at);
    const V ux = horner(vx, N, h), uy = horner(vy, N, h);
    store(ux, g.vx + at);
    store(uy, g.vy + at);
    store(horner(zx, N, h), g.zx + at);
    store(horner(zy, N, h), g.zy + at);
    if constexpr (kNeighbours) {
      Node node[2];
      for (int i = 0; i < 2; ++i) {
        const V sigma = h * kGauss[i];
        node[i] = {horner(vy, N, sigma) / horner(r, N, sigma), kappa};
      }
      const V speed = Math::sqrt(ux * ux + uy * uy), pace = 1.0 / speed, inverse = 1.0 / r[0];
      const V nx0 = vx[0] * inverse, nx1 = ux * pace;
      const Edge before{nx0, vy[0] * inverse, r[0], r[0] * (nx0 - kappa), kappa};
      const Edge after{nx1, uy * pace, speed, speed * (nx1 - kappa), kappa};
      Neighbours(g, at).carry(h, node, before, after, too_far ? V{} : gone, g, at);
    }
  }

  /// From rest v = t w, r = t rho: what the order k of n needs of itself, w and rho is a factor each.
  static void start(SlideLanes& g, int at) {
    const V kappa = load(g.kappa + at), left = load(g.left + at);
    // wx[k] stands for coefficient k + 1 of v.
    V vx[N + 1], vy[N + 1], zx[N + 1], zy[N + 1], rho[N], nx[N], ny[N];
    vx[0] = vy[0] = V{};
    zx[0] = load(g.zx + at);
    zy[0] = load(g.zy + at);
    rho[0] = 1.0 - kappa;
    nx[0] = V{} + 1.0;
    ny[0] = V{};
    vx[1] = rho[0];
    vy[1] = V{};
    zx[1] = zy[0];
    zy[1] = -zx[0];
#pragma GCC unroll 32
    for (int k = 1; k < N; ++k) {
      const double share = 1.0 / (k + 1);
      V x = vy[k] * share, y = -vx[k] * share;
      if (k > 1) {
        x -= product(rho, nx, k, 1, k - 1);
        y -= product(rho, ny, k, 1, k - 1);
      }
      nx[k] = x / (rho[0] + (kappa + 1.0) * share);
      ny[k] = y / (rho[0] + kappa * share);
      rho[k] = nx[k] * share;
      vx[k + 1] = (vy[k] - kappa * nx[k]) * share;
      vy[k + 1] = (-vx[k] - kappa * ny[k]) * share;
      zx[k + 1] = (vx[k] + zy[k]) * share;
      zy[k + 1] = (vy[k] - zx[k]) * share;
    }
    const V h = min(left, step(load(g.tolerance + at), vx, vy, zx, zy));
    store(horner(vx, N, h), g.vx + at);
    store(horner(vy, N, h), g.vy + at);
    store(horner(zx, N, h), g.zx + at);
    store(horner(zy, N, h), g.zy + at);
    store(left - h, g.left + at);
  }

 private:
  /// The nodes of Gauss's formula with two.
  static constexpr double kGauss[2] = {0.5 - 0.28867513459481288, 0.5 + 0.28867513459481288};

  /// cos and sin of |t| <= kDampedStep, to 1e-9 up to 1.
  [[gnu::always_inline]] static void cos_sin(const V& t, V& cosine, V& sine) {
    const V u = t * t;
    constexpr double kCos[] = {1, 1. / 2, 1. / 24, 1. / 720, 1. / 40320, 1. / 3628800};
    constexpr double kSin[] = {1, 1. / 6, 1. / 120, 1. / 5040, 1. / 362880, 1. / 39916800};
    cosine = V{} + kCos[5];
    sine = V{} + kSin[5];
    for (int i = 4; i >= 0; --i) {
      cosine = kCos[i] - cosine * u;
      sine = kSin[i] - sine * u;
    }
    sine *= t;
  }

  /// Inside a step: the rate at which n turns back, and that at which friction turns neighbours to it.
  struct Node {
    V turn, decay;
  };

  /// The angle from a to b, of one length; good to 1e-9 up to 1.6.
  [[gnu::always_inline]] static V angle(const V& ax, const V& ay, const V& bx, const V& by) {
    const V tangent = (ax * by - ay * bx) / (1.0 + (ax * bx + ay * by));  // of half of it
    const V x = tangent / (1.0 + Math::sqrt(1.0 + tangent * tangent)), u = x * x;
    V sum = V{} + 1.0 / 19;
    for (int i = 17; i > 0; i -= 2) sum = 1.0 / i - sum * u;
    return 4 * x * sum;
  }

  /// One end of a step in the variable q (t or sigma): n, dt/dq, its rate, and the rate of decay.
  struct Edge {
    V nx, ny, pace, pace_rate, decay;

    /// h/2 f +- h^2/12 f' of f = (dt/dq) du.
    [[gnu::always_inline]] void hermite(const V& ux, const V& uy, const V& h, double side, V& x, V& y) const {
      const V along = h * (0.5 * pace + side / 12 * h * pace_rate);
      const V across = side / 12 * h * h * pace * decay * (nx * uy - ny * ux);
      x = along * ux + across * ny;
      y = along * uy - across * nx;
    }
  };

  struct Neighbours {
    V ux[2], uy[2], yx[2], yy[2];
    [[gnu::always_inline]] Neighbours(const SlideLanes& g, int at) {
      for (int i = 0; i < 2; ++i) {
        ux[i] = load(g.ux[i] + at);
        uy[i] = load(g.uy[i] + at);
        yx[i] = load(g.yx[i] + at);
        yy[i] = load(g.yy[i] + at);
      }
    }

    /// du = alpha n + beta e, e = i n: with n turning by itself alpha' = -turn beta, beta' = turn alpha -
    /// decay beta. Over a step h, known at two nodes: the exponential of Magnus' series to fourth order
    /// (Hairer, Lubich & Wanner, Geometric Numerical Integration, IV.7), but with the exact angle, so that
    /// without friction nothing is lost. The displacements by Hermite's rule from both ends, `span` of time
    /// apart.
    [[gnu::always_inline]] void carry(const V& h, const Node* node, const Edge& before, const Edge& after,
                                      const V& span, SlideLanes& g, int at) const {
      V cosine, sine;
      cos_sin(span, cosine, sine);
      const V turned = angle(after.nx * cosine - after.ny * sine, after.nx * sine + after.ny * cosine,
                             before.nx, before.ny);
      const V half = 0.25 * h * (node[0].decay + node[1].decay);
      const V twist =
          0.14433756729740643 * h * h * (node[1].turn * node[0].decay - node[0].turn * node[1].decay);
      const V p = twist - turned, q = twist + turned, square = half * half + p * q;
      V even = V{} + 1.0 / 479001600, odd = V{} + 1.0 / 6227020800.;  // cosh and sinh/argument of its root
      constexpr double kEven[] = {1, 1. / 2, 1. / 24, 1. / 720, 1. / 40320, 1. / 3628800};
      constexpr double kOdd[] = {1, 1. / 6, 1. / 120, 1. / 5040, 1. / 362880, 1. / 39916800};
      for (int i = 5; i >= 0; --i) {
        even = even * square + kEven[i];
        odd = odd * square + kOdd[i];
      }
      constexpr double kExp[] = {1,        1,         1. / 2,     1. / 6,       1. / 24,      1. / 120,
                                 1. / 720, 1. / 5040, 1. / 40320, 1. / 362880., 1. / 3628800.};
      V damping = V{} + kExp[10];
      for (int i = 9; i >= 0; --i) damping = kExp[i] - damping * half;
      const V aa = damping * (even + odd * half), ab = damping * odd * p, ba = damping * odd * q,
              bb = damping * (even - odd * half);
      for (int i = 0; i < 2; ++i) {
        const V alpha0 = ux[i] * before.nx + uy[i] * before.ny, beta0 = uy[i] * before.nx - ux[i] * before.ny;
        const V alpha = aa * alpha0 + ab * beta0, beta = ba * alpha0 + bb * beta0;
        const V x1 = alpha * after.nx - beta * after.ny, y1 = alpha * after.ny + beta * after.nx;
        V fx, fy, gx, gy;
        before.hermite(ux[i], uy[i], h, 1.0, fx, fy);
        after.hermite(x1, y1, h, -1.0, gx, gy);
        fx += yx[i];
        fy += yy[i];
        store(x1, g.ux[i] + at);
        store(y1, g.uy[i] + at);
        store(fx * cosine + fy * sine + gx, g.yx[i] + at);
        store(fy * cosine - fx * sine + gy, g.yy[i] + at);
      }
    }
  };
};

}  // namespace tribotrack::model::internal
