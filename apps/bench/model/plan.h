// What each omission of model/plan.h saves, measured.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/model/bench.h"

namespace tribotrack::bench {

/// One omission on a scene where it applies: the same motion with and without the machinery. Medians of CPU
/// times, the two taken in turn.
struct PlanBenchRow {
  std::string omission;     ///< the stage's name in the plan
  std::string scene;        ///< what is compared with what
  double time_with = 0;     ///< s
  double time_without = 0;  ///< s
  double saving = 0;        ///< measured: 1 - without/with; below 0 where it costs
  double error = 0;         ///< m, between the two end points; NaN where they are not the same motion
  double error_bound = 0;   ///< m, by the plan
  int repetitions = 0;
};

std::vector<PlanBenchRow> bench_plan(const ModelBenchOptions& options = {});

}  // namespace tribotrack::bench
