// Is the model right? Tilt, scatter, alternative friction laws, in this order and only where needed.
#pragma once

#include <vector>

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

/// Chance of so few changes of sign (Wald and Wolfowitz) in the residuals along and across the modelled
/// displacement, runs in the order of their pulse width and phi: small where neighbours err alike, as they do
/// under a wrong model and do not under scatter. 1 for fewer than eight summary runs.
double runs_test(const Residuals& residuals, const Minimum& best);

/// The models compared, the one fitted first; empty where neither residuals nor user require it. `best` is
/// the minimum without scatter, `p_value` its own. What was not tried goes to result.left_out, what was found
/// to result.warnings.
void check_model(const Residuals& residuals, const Minimum& best, const FitOptions& options,
                 FitResult& result);

}  // namespace tribotrack::fit::internal
