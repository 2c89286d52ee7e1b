// Whether the cycles of a run have come to repeat, and what taking them as copies adds to its error.
#pragma once

#include <cmath>

namespace tribotrack::model::internal {

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

}  // namespace tribotrack::model::internal
