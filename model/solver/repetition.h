// What is left of a run once its cycles have nearly come to repeat.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tribotrack::model::internal {

/// The one-cycle map U -> P(U) at one cycle's start, and the cycle's displacement D(U).
struct CycleMap {
  Eigen::Vector2d end, drift;             ///< P(U), D(U)
  Eigen::Matrix2d jacobian, drift_slope;  ///< dP/dU, dD/dU
};

struct Remainder {
  Eigen::Vector2d velocity_change = Eigen::Vector2d::Zero(), displacement = Eigen::Vector2d::Zero();
  double apart = 0;  ///< from the cycles left out, in velocity
  double error = 0;  ///< of the displacement
};

/// Sum of min(k, 1/(1 - q)), k = 1 .. copies.
inline double sum_of_gaps(double q, double copies) {
  const double level = q < 1 ? 1 / (1 - q) : HUGE_VAL;
  const double rising = std::fmin(copies, std::floor(level));
  return 0.5 * rising * (rising + 1) + (copies > rising ? (copies - rising) * level : 0);
}

/// Error of the displacement when `copies` further cycles are taken as copies of the last one. The flow of
/// the velocity is a contraction: where successive cycles begin `gap` apart, the k-th further cycle's
/// velocity is nowhere farther than k gap from the last one's, nor than gap/(1 - q) if gaps go on shrinking
/// at least by q; and a displacement is at most 2 pi times the velocity's error off.
inline double copying_error(double gap, double q, double copies) {
  return 2 * M_PI * gap * sum_of_gaps(q, copies);
}

/// How gaps between successive cycles' starts shrink, and when what is left of them is rounding: they then
/// flicker at its level for ever, without two cycles that agree to the last digit.
class Shrinking {
 public:
  /// Per cycle, where it is known.
  explicit Shrinking(double contraction) : contraction_(contraction) {}

  /// Whether a gap that followed `before` after a cycle of so many steps is rounding: within what the steps'
  /// own rounding adds up to, no longer shrinking, and after a contraction that leaves no doubt about where
  /// it led; a stop on the way leaves none at once. Gaps come in their order, of the first none is `before`.
  bool settled(double gap, double before, double steps, bool stopped) {
    rounding_ = 2.3e-16 * (4 + 0.25 * steps);
    if (stopped) {
      contraction_ = 0;
    } else if (gap > rounding_) {
      const double ratio = gap / before;
      contraction_ = contraction_ < HUGE_VAL ? std::sqrt(contraction_ * ratio) : ratio;
    }
    return gap <= rounding_ && gap > 0.5 * before && contraction_ < 0.75;
  }
  /// Of the displacement of `copies` further cycles: all of them begin within (gap + rounding)/(1 - q).
  double error(double gap, double copies) const {
    return 2 * M_PI * (gap + rounding_) / (1 - contraction_) * copies;
  }

 private:
  double contraction_, rounding_ = 0;
};

/// `copies` more cycles after the one `map` describes, which began at `start`, `before` away from where the
/// one before it began: d_{k+1} = J d_k, D_{k+1} = D_k + G d_k for the differences d_k of successive starts.
/// Leaves out terms of second order in d; how large they are shows in d_0 - J d_{-1}, and they fall with d^2.
inline Remainder extrapolate(const CycleMap& map, const Eigen::Vector2d& start, const Eigen::Vector2d& before,
                             double copies) {
  using Matrix = Eigen::Matrix2d;
  const Eigen::Vector2d d = map.end - start;
  const Matrix inverse = (Matrix::Identity() - map.jacobian).inverse();
  if (!(inverse.norm() < 10)) {  // no contraction worth the name: gaps that shrank were rounding
    Remainder none;
    none.apart = none.error = HUGE_VAL;
    return none;
  }
  Matrix power = Matrix::Identity(), square = map.jacobian;  // J^copies
  for (double n = copies; n >= 1; n = std::floor(n / 2), square = (square * square).eval())
    if (std::fmod(n, 2) == 1) power = (power * square).eval();
  const Eigen::Vector2d geometric = inverse * (d - power * d);  // sum of J^i d, i = 0 .. copies - 1
  Remainder rest;
  rest.velocity_change = map.jacobian * geometric;
  rest.displacement =
      copies * map.drift + map.drift_slope * (inverse * (copies * d - map.jacobian * geometric));
  const double q = std::fmin(d.norm() / before.norm(), 0.99);
  const double second_order = (d - map.jacobian * before).norm() * q * q;
  rest.apart = second_order / (1 - q);
  rest.error = copying_error(second_order, q, copies);
  return rest;
}

}  // namespace tribotrack::model::internal
