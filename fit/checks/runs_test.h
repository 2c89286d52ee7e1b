// Do the residuals of neighbouring runs go together, as they do under a wrong model?
#pragma once

#include <vector>

#include "fit/fit_result.h"

namespace tribotrack::fit::internal {

/// p of so few changes of sign, along and across the displacements, among summary runs sorted by dtau and phi
/// (Wald and Wolfowitz, Ann. Math. Stat. 11, 147, 1940). 1 with fewer than eight runs.
double runs_test(const std::vector<RunResult>& runs);

}  // namespace tribotrack::fit::internal
