// An arc of sliding solved as a whole, by collocation.
#pragma once

#include "model/equation/scaled_problem.h"

namespace tribotrack::model::internal {

/// Gauss-Legendre collocation (Hairer & Wanner, Solving ODEs II, IV.5) in mirrored pairs: with P pairs of
/// nodes c_i = 1 - c'_i and a'_ij' = b_j - a_ij, the integrals from 0 to every node of a function known at
/// the nodes are
///   front_i = sum_j even[j][i] (f_j + f'_j) + odd[j][i] (f_j - f'_j),   mirror_i = sum_j b_j (f_j + f'_j) -
///   even + odd:
/// half the multiplications. Pair P is the arc's end c = 1 with its start c' = 0, so that the last lane of
/// `front` is the value at the end.
struct GaussTable {
  static constexpr int kMaxLanes = 8, kMaxNodes = 14;
  int pairs = 0;
  alignas(64) double even[kMaxLanes][kMaxLanes], odd[kMaxLanes][kMaxLanes];
  alignas(64) double front[kMaxLanes], mirror[kMaxLanes];                ///< c, c'
  alignas(64) double moment_front[kMaxLanes], moment_mirror[kMaxLanes];  ///< b (1 - c)
  alignas(64) double tail_front[kMaxLanes], tail_mirror[kMaxLanes];      ///< to the last Legendre coefficient
  alignas(64) double weight[kMaxNodes], moment[kMaxNodes],
      node[kMaxNodes];                                   ///< b, b (1 - c), c in ascending order
  alignas(64) double to_legendre[kMaxNodes][kMaxNodes];  ///< [k][j]: coefficient of P_k(2c - 1)
  alignas(64) double integrate[kMaxNodes][16];           ///< a_ij in ascending order

  /// For 3 or 7 pairs.
  static const GaussTable& of_pairs(int pairs);

  /// Weights that integrate a function known at the nodes from 0 to c, once and twice.
  void integrals_to(double c, double* once, double* twice) const;
};

/// What an arc was, for the same stretch of the next cycle to begin with: the integrals of U/|U| to the nodes
/// in units of the span.
struct ArcTrace {
  alignas(64) double front_x[GaussTable::kMaxLanes], front_y[GaussTable::kMaxLanes];
  alignas(64) double mirror_x[GaussTable::kMaxLanes], mirror_y[GaussTable::kMaxLanes];
};

/// The arc: dU/dt = constant + p cos t + q sin t - kappa U/|U|, t = -span/2 .. span/2 (so p, q belong to its
/// middle).
struct ArcInput {
  Pair<double> constant, p, q;
  double kappa = 0;
  double span = 0;
  Pair<double> velocity;      ///< at its start
  double tolerance = 0;       ///< of the velocity, absolute
  double resolution = 0;      ///< of the velocity, relative to the slowest
  double slowest = 0;         ///< an arc that falls below this speed is none
  double rounding = 0;        ///< changes of U over |U|^2 below this tell nothing
  bool keep = false;          ///< the directions at the nodes
  ArcTrace* trace = nullptr;  ///< out, if converged; in if `traced`
  bool traced = false;
};

struct ArcOutput {
  Pair<double> velocity;      ///< at its end
  Pair<double> displacement;  ///< from start to end
  double error = 0;           ///< truncation error of the velocity over `slowest`
  double slowest = 0;         ///< least |U| at the nodes and both ends
  bool converged = false;
  bool accepted = false;  ///< converged, resolved and not too slow: derivatives are those of such arcs only
  double direction_x[GaussTable::kMaxNodes],
      direction_y[GaussTable::kMaxNodes];  ///< U/|U| in ascending order
};

/// Derivatives by `columns` parameters, in columns side by side.
struct ArcColumns {
  static constexpr int kMax = 16;
  int count = 0;              ///< 4, 8 or 16
  bool drive_varies = false;  ///< whether constant, p, q have any
  struct Row {
    alignas(64) double x[kMax] = {}, y[kMax] = {};
  };
  alignas(64) double kappa[kMax] = {};
  Row constant, p, q;
  Row velocity;      ///< in: at the start; out: at the end
  Row displacement;  ///< out
  alignas(64) double turn[GaussTable::kMaxNodes][kMax] =
      {};  ///< out if kept: by how much U/|U| turns at the nodes
};

/// Solves the arc: by 3 pairs of nodes, or by 7. `columns` may be null.
using ArcSolver = void(const GaussTable& table, const ArcInput& in, ArcOutput& out, ArcColumns* columns);
ArcSolver solve_arc_few, solve_arc_many;

}  // namespace tribotrack::model::internal
