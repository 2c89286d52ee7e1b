// The model solved for every scenario of a sweep.
#pragma once

#include <vector>

#include "apps/files/sweeps/sweep_axis.h"
#include "apps/program/context.h"
#include "model/batch.h"

namespace tribotrack::apps {

/// One value for each scenario (Sweep::scenario()); NaN where there is none.
struct SweptModel {
  std::vector<double> alpha_rad, v_mm_s;                ///< of the runs
  std::vector<double> steady_alpha_rad, steady_v_mm_s;  ///< of the steady motion under the same conditions
  model::BatchSummary summary;
};

/// On all threads, with progress. Refuses a scenario out of range before the work, not after it: InvalidInput
/// naming the axes.
SweptModel solve(const Sweep& sweep, const Context& context);

}  // namespace tribotrack::apps
