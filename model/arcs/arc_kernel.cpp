// The collocation of an arc.
#include "model/arcs/arc.h"
#include "model/equation/lanes.h"

namespace tribotrack::model::internal {
namespace {

/// cos and sin of |t| <= 1.05 to rounding.
template <class V>
TRIBOTRACK_KERNEL void cos_sin(const V& t, V& cosine, V& sine) {
  const V z = t * t;
  constexpr double kCos[] = {1. / 2,
                             1. / 24,
                             1. / 720,
                             1. / 40320,
                             1. / 3628800,
                             1. / 479001600,
                             1. / 87178291200.,
                             1. / 20922789888000.,
                             1. / 6402373705728000.};
  constexpr double kSin[] = {1. / 6,        1. / 120,         1. / 5040,           1. / 362880,
                             1. / 39916800, 1. / 6227020800., 1. / 1307674368000., 1. / 355687428096000.};
  V c = kCos[7] - z * kCos[8], s = kSin[6] - z * kSin[7];
  c = kCos[6] - z * c;
  for (int k = 5; k >= 0; --k) {
    c = kCos[k] - z * c;
    s = kSin[k] - z * s;
  }
  cosine = 1.0 - z * c;
  sine = t - t * (z * s);
}

/// U at the nodes solves U_i = W_i - kappa h sum_j a_ij n_j, n = U/|U|, W = start + integral of the drive
/// (exact). Picard sweeps: each brings a factor of about (kappa h/|U|)/(number of the sweep).
template <int L>
struct ArcKernel {
  using V = Lanes<L>;
  static constexpr int kPairs = L - 1, kNodes = 2 * kPairs;
  /// Share of the last Legendre coefficient that the velocity between the nodes is off by.
  static constexpr double kWithin = 0.02;
  static constexpr int kMaxSweeps = 48, kSweepsToGain = 16;

  TRIBOTRACK_KERNEL void direction(const V& x, const V& y, V& nx, V& ny, V& square, V& inverse) {
    square = x * x + y * y;
    inverse = 1.0 / root(square);
    nx = x * inverse;
    ny = y * inverse;
  }

  /// Lanes into ascending order.
  TRIBOTRACK_KERNEL void take(double* to, const V& front, const V& mirror) {
    for (int i = 0; i < kPairs; ++i) {
      to[i] = front[i];
      to[kNodes - 1 - i] = mirror[i];
    }
  }

  TRIBOTRACK_KERNEL void solve(const GaussTable& g, const ArcInput& in, ArcOutput& out, ArcColumns* columns) {
    const double h = in.span;
    const V cf = load<V>(g.front), cm = load<V>(g.mirror);
    // Integrals of cos and sin from the start -h/2 to the nodes.
    V cos_f, sin_f;
    cos_sin(V(cf * h - 0.5 * h), cos_f, sin_f);
    const double S = sin_f[kPairs], C = cos_f[kPairs];
    // cos is even, sin odd about the middle.
    const V int_cos_f = sin_f + S, int_cos_m = S - sin_f, int_sin = C - cos_f;
    const V wx_f = in.velocity.x + in.p.x * int_cos_f + in.q.x * int_sin + (in.constant.x * h) * cf;
    const V wy_f = in.velocity.y + in.p.y * int_cos_f + in.q.y * int_sin + (in.constant.y * h) * cf;
    const V wx_m = in.velocity.x + in.p.x * int_cos_m + in.q.x * int_sin + (in.constant.x * h) * cm;
    const V wy_m = in.velocity.y + in.p.y * int_cos_m + in.q.y * int_sin + (in.constant.y * h) * cm;

    const double pull = -in.kappa * h;
    // First guess: friction acts as in the cycle before, or the velocity turns with the drive.
    V ux_f, uy_f, ux_m, uy_m;
    if (in.traced) {
      ux_f = wx_f + pull * load<V>(in.trace->front_x);
      uy_f = wy_f + pull * load<V>(in.trace->front_y);
      ux_m = wx_m + pull * load<V>(in.trace->mirror_x);
      uy_m = wy_m + pull * load<V>(in.trace->mirror_y);
    } else {
      const double speed = __builtin_sqrt(in.velocity.x * in.velocity.x + in.velocity.y * in.velocity.y);
      const double turn = in.p.x * in.q.y - in.p.y * in.q.x > 0 ? 1 : -1;
      const double nx0 = in.velocity.x / speed, ny0 = in.velocity.y / speed, pace = pull / h;
      const V sine_f = C * sin_f + S * cos_f, sine_m = S * cos_f - C * sin_f;
      const V rest_f = 1.0 - (C * cos_f - S * sin_f), rest_m = 1.0 - (C * cos_f + S * sin_f);
      ux_f = wx_f + pace * (nx0 * sine_f - (turn * ny0) * rest_f);
      uy_f = wy_f + pace * (ny0 * sine_f + (turn * nx0) * rest_f);
      ux_m = wx_m + pace * (nx0 * sine_m - (turn * ny0) * rest_m);
      uy_m = wy_m + pace * (ny0 * sine_m + (turn * nx0) * rest_m);
    }

    alignas(64) double even_x[L], even_y[L], odd_x[L], odd_y[L];
    V nx_f, ny_f, nx_m, ny_m, square_f, square_m, inverse_f, inverse_m, ix_f, iy_f, ix_m, iy_m;
    out.converged = false;
    int sweep = 0;
    while (true) {
      direction(ux_f, uy_f, nx_f, ny_f, square_f, inverse_f);
      direction(ux_m, uy_m, nx_m, ny_m, square_m, inverse_m);
      store(nx_f + nx_m, even_x);
      store(ny_f + ny_m, even_y);
      store(nx_f - nx_m, odd_x);
      store(ny_f - ny_m, odd_y);
      V px{}, py{}, qx{}, qy{};
#pragma GCC unroll 8
      for (int j = 0; j < kPairs; ++j) {
        const V e = load<V>(g.even[j]), o = load<V>(g.odd[j]);
        px += e * even_x[j];
        py += e * even_y[j];
        qx += o * odd_x[j];
        qy += o * odd_y[j];
      }
      ix_f = qx + px;
      iy_f = qy + py;
      ix_m = px[kPairs] + (qx - px);
      iy_m = py[kPairs] + (qy - py);
      if (out.converged || sweep == kMaxSweeps) break;
      ++sweep;
      const V vx_f = wx_f + pull * ix_f, vy_f = wy_f + pull * iy_f, vx_m = wx_m + pull * ix_m,
              vy_m = wy_m + pull * iy_m;
      const V dx_f = vx_f - ux_f, dy_f = vy_f - uy_f, dx_m = vx_m - ux_m, dy_m = vy_m - uy_m;
      ux_f = vx_f;
      uy_f = vy_f;
      ux_m = vx_m;
      uy_m = vy_m;
      // Two sweeps on (the sums below are one) (kappa h/|U|)^2/((sweep + 1)(sweep + 2)) of a change of U is
      // left.
      const V left_f = inverse_f * inverse_f, left_m = inverse_m * inverse_m;
      const V moved =
          left_f * left_f * (dx_f * dx_f + dy_f * dy_f) + left_m * left_m * (dx_m * dx_m + dy_m * dy_m);
      const double allowed =
          __builtin_fmax(0.5 * in.tolerance * (sweep + 1) * (sweep + 2) / (pull * pull), in.rounding);
      out.converged = all_below(moved, allowed * allowed);
      // By now sweeps that will get there gain by the sweep.
      if (sweep == kSweepsToGain && !(all_below(moved * square_f, 0.01) && all_below(moved * square_m, 0.01)))
        break;
    }
    out.velocity = {wx_f[kPairs] + pull * ix_f[kPairs], wy_f[kPairs] + pull * iy_f[kPairs]};
    const V moment_f = load<V>(g.moment_front), moment_m = load<V>(g.moment_mirror);
    const double mx = sum(moment_f * nx_f + moment_m * nx_m), my = sum(moment_f * ny_f + moment_m * ny_m);
    // int_0^h of the drive's integrals
    const double along = S * h, turned = C * h - 2 * S, half = 0.5 * h * h;
    out.displacement = {
        h * in.velocity.x + in.p.x * along + in.q.x * turned + in.constant.x * half + pull * h * mx,
        h * in.velocity.y + in.p.y * along + in.q.y * turned + in.constant.y * half + pull * h * my};
    const V tail_f = load<V>(g.tail_front), tail_m = load<V>(g.tail_mirror);
    const double tx = sum(tail_f * nx_f + tail_m * nx_m), ty = sum(tail_f * ny_f + tail_m * ny_m);
    const double tail = __builtin_fabs(tx) + __builtin_fabs(ty);
    const V least = square_f < square_m ? square_f : square_m;
    double slowest = least[0];
    for (int i = 1; i < L; ++i) slowest = least[i] < slowest ? least[i] : slowest;
    out.slowest = __builtin_sqrt(slowest);
    // At the end the truncation error is the square of that in between.
    out.error = in.kappa * h * (in.keep ? kWithin * tail : tail * tail) / out.slowest;
    out.accepted = out.converged && out.error <= in.resolution && out.slowest >= in.slowest;
    if (in.trace && out.converged) {
      store(ix_f, in.trace->front_x);
      store(iy_f, in.trace->front_y);
      store(ix_m, in.trace->mirror_x);
      store(iy_m, in.trace->mirror_y);
    }
    if (in.keep) {
      take(out.direction_x, nx_f, nx_m);
      take(out.direction_y, ny_f, ny_m);
    }
    if (columns && out.accepted) {
      Solution solution;
      solution.sine = S;
      solution.cosine = C;
      take(solution.nx, nx_f, nx_m);
      take(solution.ny, ny_f, ny_m);
      take(solution.ix, ix_f, ix_m);
      take(solution.iy, iy_f, iy_m);
      take(solution.cosines, int_cos_f, int_cos_m);
      take(solution.sines, int_sin, int_sin);
      take(solution.speed, root(square_f), root(square_m));
      solution.end_x = ix_f[kPairs];
      solution.end_y = iy_f[kPairs];
      solution.moment_x = mx;
      solution.moment_y = my;
      if (columns->count == 4)
        differentiate<4>(g, in, solution, *columns);
      else if (columns->count == 8)
        differentiate<8>(g, in, solution, *columns);
      else
        differentiate<16>(g, in, solution, *columns);
    }
  }

  /// The converged arc, node by node in ascending order.
  struct Solution {
    double nx[kNodes], ny[kNodes];          ///< n
    double ix[kNodes], iy[kNodes];          ///< its integrals from 0, in units of the span
    double cosines[kNodes], sines[kNodes];  ///< integrals of cos and sin
    double speed[kNodes];
    double end_x, end_y, moment_x, moment_y;  ///< sums of b n and b (1 - c) n
    double sine, cosine;                      ///< of half the span
  };

  /// The same equation differentiated: friction answers only to what moves U across n, dn = (e.dU/|U|) e with
  /// e = n turned by 90 degrees. So with y = e.dU/|U|, one number per node,
  ///   |U_i| y_i + kappa h sum_j a_ij (n_i.n_j) y_j = e_i.(dW_i - h dkappa sum_j a_ij n_j),
  /// a small linear system for all columns at once.
  template <int C>
  TRIBOTRACK_KERNEL void differentiate(const GaussTable& g, const ArcInput& in, const Solution& u,
                                       ArcColumns& d) {
    constexpr int kWidth = C < 8 ? C : 8, kParts = C / kWidth;
    constexpr int kStride = kNodes <= 8 ? 8 : 16;
    using Part = Lanes<kWidth>;
    const double h = in.span;
    alignas(64) double nx[kStride] = {}, ny[kStride] = {}, matrix[kNodes][kStride], inverse[kNodes];
    Part y[kNodes][kParts];
    for (int i = 0; i < kNodes; ++i) {
      nx[i] = u.nx[i];
      ny[i] = u.ny[i];
    }
    for (int i = 0; i < kNodes; ++i) {
      const double kx = in.kappa * h * nx[i], ky = in.kappa * h * ny[i];
      for (int j = 0; j < kStride; j += 8)
        store(
            load<Lanes<8>>(g.integrate[i] + j) * (kx * load<Lanes<8>>(nx + j) + ky * load<Lanes<8>>(ny + j)),
            matrix[i] + j);
      matrix[i][i] += u.speed[i];
      const double ex = -ny[i], ey = nx[i], friction = h * (ex * u.ix[i] + ey * u.iy[i]);
      for (int k = 0; k < kParts; ++k) {
        const int at = k * kWidth;
        const auto part = [at](const double* row) __attribute__((always_inline)) {
          return load<Part>(row + at);
        };
        y[i][k] = ex * part(d.velocity.x) + ey * part(d.velocity.y) - friction * part(d.kappa);
        if (d.drive_varies) {
          const double t = h * g.node[i], c = u.cosines[i], s = u.sines[i];
          y[i][k] += ex * (t * part(d.constant.x) + c * part(d.p.x) + s * part(d.q.x)) +
                     ey * (t * part(d.constant.y) + c * part(d.p.y) + s * part(d.q.y));
        }
      }
    }
    // Gaussian elimination. The diagonal leads: |U| + kappa h a_ii.
    for (int k = 0; k < kNodes; ++k) {
      inverse[k] = 1 / matrix[k][k];
      for (int i = k + 1; i < kNodes; ++i) {
        const double factor = matrix[i][k] * inverse[k];
        for (int j = (k + 1) & ~7; j < kStride; j += 8)
          store(load<Lanes<8>>(matrix[i] + j) - factor * load<Lanes<8>>(matrix[k] + j), matrix[i] + j);
        for (int c = 0; c < kParts; ++c) y[i][c] -= factor * y[k][c];
      }
    }
    for (int k = kNodes - 1; k >= 0; --k) {
      for (int c = 0; c < kParts; ++c) y[k][c] *= inverse[k];
      for (int i = 0; i < k; ++i)
        for (int c = 0; c < kParts; ++c) y[i][c] -= matrix[i][k] * y[k][c];
    }
    if (in.keep)
      for (int i = 0; i < kNodes; ++i)
        for (int c = 0; c < kParts; ++c) store(y[i][c], d.turn[i] + c * kWidth);
    const double S = u.sine, half_cosine = u.cosine, kappa_h = in.kappa * h;
    for (int c = 0; c < kParts; ++c) {
      Part vx{}, vy{}, mx{}, my{};
      for (int i = 0; i < kNodes; ++i) {
        const double b = g.weight[i], m = g.moment[i];
        vx -= (b * ny[i]) * y[i][c];
        vy += (b * nx[i]) * y[i][c];
        mx -= (m * ny[i]) * y[i][c];
        my += (m * nx[i]) * y[i][c];
      }
      const int at = c * kWidth;
      const Part ux = load<Part>(d.velocity.x + at), uy = load<Part>(d.velocity.y + at),
                 dk = load<Part>(d.kappa + at);
      Part end_x = ux - (h * u.end_x) * dk - kappa_h * vx, end_y = uy - (h * u.end_y) * dk - kappa_h * vy;
      Part moved_x = h * ux - (h * h * u.moment_x) * dk - (h * kappa_h) * mx;
      Part moved_y = h * uy - (h * h * u.moment_y) * dk - (h * kappa_h) * my;
      if (d.drive_varies) {
        const double along = S * h, turned = half_cosine * h - 2 * S, half = 0.5 * h * h;
        const Part cx = load<Part>(d.constant.x + at), cy = load<Part>(d.constant.y + at),
                   px = load<Part>(d.p.x + at), py = load<Part>(d.p.y + at), qx = load<Part>(d.q.x + at),
                   qy = load<Part>(d.q.y + at);
        end_x += h * cx + (2 * S) * px;
        end_y += h * cy + (2 * S) * py;
        moved_x += half * cx + along * px + turned * qx;
        moved_y += half * cy + along * py + turned * qy;
      }
      store(end_x, d.velocity.x + at);
      store(end_y, d.velocity.y + at);
      store(moved_x, d.displacement.x + at);
      store(moved_y, d.displacement.y + at);
    }
  }
};

}  // namespace

TRIBOTRACK_CLONES void solve_arc_few(const GaussTable& g, const ArcInput& in, ArcOutput& out,
                                     ArcColumns* columns) {
  ArcKernel<4>::solve(g, in, out, columns);
}

TRIBOTRACK_CLONES void solve_arc_many(const GaussTable& g, const ArcInput& in, ArcOutput& out,
                                      ArcColumns* columns) {
  ArcKernel<8>::solve(g, in, out, columns);
}

}  // namespace tribotrack::model::internal
