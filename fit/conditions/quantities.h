// A, A_y, w, epsilon: each one quantity in all runs.
#pragma once

#include <span>

#include "fit/conditions.h"

namespace tribotrack::fit::internal {

/// Mean over the runs that are counted; 0 for none.
double mean_over(std::span<const RunEvidence> runs, const auto& counted, const auto& of) {
  double sum = 0;
  int count = 0;
  for (const RunEvidence& run : runs)
    if (counted(run)) {
      sum += of(run);
      ++count;
    }
  return count > 0 ? sum / count : 0;
}

inline bool is_driven(const RunEvidence& run) {
  return run.driven;
}
inline bool is_scaled(const RunEvidence& run) {
  return run.scale.has_value();
}

/// Fills `quantities` and `slips`, and drive, own errors and amplitude_from_track of `runs`, which hold what
/// the evidence does so far.
void pool_quantities(std::span<const RunEvidence> runs, const SharedEvidence& shared, Conditions& conditions);

}  // namespace tribotrack::fit::internal
