// Many runs at once against one at a time.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/bench/model/bench.h"

namespace tribotrack::bench {

/// One kind of sweep, solved side by side in one instruction set and by the scalar integrator in the best.
/// CPU times of one thread, per scenario: medians, the competitors taken in turn.
struct BatchBenchRow {
  std::string sweep;            ///< which scenarios
  std::string wanted;           ///< "ends" (20 cycles from rest) or "steady"
  std::string instruction_set;  ///< of the lanes
  std::size_t scenarios = 0;
  double in_lanes = 0;     ///< share of the scenarios; the others went the scalar way
  double full = 0;         ///< share of the lanes' room that was used
  double time_scalar = 0;  ///< s; NaN in the row of the whole sweep
  double time_lanes = 0;   ///< s
  double speedup = 0;      ///< time_scalar / time_lanes
  /// A sweep of 1000 x 1000 on two cores, s: extrapolated, and in the last row of all measured on the wall's
  /// clock (of `scenarios` scenarios), the load of other programs included.
  double million = 0;
  double difference = 0;  ///< largest distance between the two solutions, in amplitudes of the drive; NaN too
  int repetitions = 0;
};

std::vector<BatchBenchRow> bench_batch(const ModelBenchOptions& options = {});

}  // namespace tribotrack::bench
