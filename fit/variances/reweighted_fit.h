// Minimum, scatter and robust weights, which depend on each other.
#pragma once

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"
#include "fit/variances/correlated_variances.h"

namespace tribotrack::fit::internal {

/// What is estimated beside the parameters.
struct Reweighting {
  bool correlated_errors = false;  ///< of driven trajectory runs
  bool scatter = false;            ///< of runs and points
  Loss loss = Loss::squares;
};

/// Descends from `best`, estimates correlated errors, scatter and weights there, and again, until none moves:
/// a few rounds. On return the residuals carry all of them.
CorrelatedEstimate reweighted_fit(Residuals& residuals, Minimum& best, const Reweighting& reweighting);

/// Of runs or points; correlated errors are not counted.
bool any(const ExcessVariance& scatter);

}  // namespace tribotrack::fit::internal
