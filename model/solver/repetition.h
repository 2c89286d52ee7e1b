// Whether the cycles of a run have come to repeat.
#pragma once

#include <cmath>

namespace tribotrack::model::internal {

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
    const double rounding = 2.3e-16 * (4 + 0.25 * steps);
    if (stopped) {
      contraction_ = 0;
    } else if (gap > rounding) {
      const double ratio = gap / before;
      contraction_ = contraction_ < HUGE_VAL ? std::sqrt(contraction_ * ratio) : ratio;
    }
    return gap <= rounding && gap > 0.5 * before && contraction_ < 0.75;
  }

 private:
  double contraction_;
};

}  // namespace tribotrack::model::internal
