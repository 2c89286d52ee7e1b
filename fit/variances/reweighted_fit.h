// Minimum, scatter and robust weights, which depend on each other.
#pragma once

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"
#include "fit/variances/correlated_variances.h"

namespace tribotrack::fit::internal {

/// What is estimated beside the parameters.
struct Settling {
  bool slow_errors = false;  ///< of driven trajectory runs
  bool scatter = false;      ///< of runs and points
  Loss loss = Loss::squares;
};

/// Descends from `best`, estimates slow errors, scatter and weights there, and again, until none moves: a few
/// rounds. On return the residuals carry all of them.
SlowEstimate settle(Residuals& residuals, Minimum& best, const Settling& settling);

/// Of runs or points; slow errors are another matter.
bool any(const Scatter& scatter);

}  // namespace tribotrack::fit::internal
