// An arc of sliding solved as a whole, by collocation.
#pragma once

#include "model/equation/scaled_problem.h"

namespace tribotrack::model::internal {

/// Gauss-Legendre collocation (Hairer & Wanner, Solving ODEs II, IV.5) in mirrored pairs: with P = 7 pairs of
/// nodes c_i = 1 - c'_i and a'_ij' = b_j - a_ij, the integrals from 0 to every node of a function known at
/// the nodes are
///   front_i = sum_j even[j][i] (f_j + f'_j) + odd[j][i] (f_j - f'_j),   mirror_i = sum_j b_j (f_j + f'_j) -
///   even + odd:
/// half the multiplications. Pair P is the arc's end c = 1 with its start c' = 0, so that the last lane of
/// `front` is the value at the end.
struct GaussTable {
  static constexpr int kPairs = 7, kLanes = kPairs + 1, kNodes = 2 * kPairs;
  alignas(64) double even[kLanes][kLanes], odd[kLanes][kLanes];
  alignas(64) double front[kLanes], mirror[kLanes];                ///< c, c'
  alignas(64) double moment_front[kLanes], moment_mirror[kLanes];  ///< b (1 - c)
  alignas(64) double tail_front[kLanes], tail_mirror[kLanes];      ///< to the last Legendre coefficient
  alignas(64) double weight[kNodes], moment[kNodes],
      node[kNodes];                                ///< b, b (1 - c), c in ascending order
  alignas(64) double to_legendre[kNodes][kNodes];  ///< [k][j]: coefficient of P_k(2c - 1)
  alignas(64) double integrate[kNodes][16];        ///< a_ij in ascending order

  static const GaussTable& get();

  /// Weights that integrate a function known at the nodes from 0 to c, once and twice.
  void integrals_to(double c, double* once, double* twice) const;
};

/// What an arc was, for the same stretch of the next cycle to begin with: the integrals of U/|U| to the nodes
/// in units of the span.
struct ArcTrace {
  alignas(64) double front_x[GaussTable::kLanes], front_y[GaussTable::kLanes];
  alignas(64) double mirror_x[GaussTable::kLanes], mirror_y[GaussTable::kLanes];
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
  double direction_x[GaussTable::kNodes],
      direction_y[GaussTable::kNodes];  ///< U/|U| in ascending order
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
  alignas(
      64) double turn[GaussTable::kNodes][kMax] = {};  ///< out if kept: by how much U/|U| turns at the nodes
};

/// Solves the arc. `columns` may be null.
using ArcSolver = void (*)(const GaussTable& table, const ArcInput& in, ArcOutput& out, ArcColumns* columns);

}  // namespace tribotrack::model::internal
