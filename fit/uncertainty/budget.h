// The uncertainty budget: which source makes how much of each parameter's standard deviation.
//
// To first order the estimates are theta = -C J'r + const, C = (J'J)^-1, r the whitened residuals, priors and
// conditions among them. A source whose errors have the covariance V_s in the rows that it enters, whitened,
// contributes C J' V_s J C; those of all sources add up to C J' J C = C.
#pragma once

#include <string>
#include <vector>

#include "fit/fit_result.h"
#include "fit/minimum/minimise.h"
#include "fit/uncertainty/covariance.h"

namespace tribotrack::fit::internal {

/// Counted sources, the largest first, then what was taken as exact with what an error of 1 % (0.01 rad of an
/// angle, 0.001 rad of a tilt) would add. Empty where a parameter is not determined.
std::vector<BudgetEntry> budget(const Residuals& residuals, const Minimum& best,
                                const Uncertainty& uncertainty);

/// "gravity is taken as exact; with 1 % more of it: mu1 down 1 %, ...": a sentence for each such entry.
std::vector<std::string> taken_as_exact(const std::vector<BudgetEntry>& budget,
                                        const std::vector<ParameterEstimate>& parameters);

/// The largest source of the parameters' variances and what to do about it.
std::string improve_first(const std::vector<BudgetEntry>& budget,
                          const std::vector<ParameterEstimate>& parameters);

}  // namespace tribotrack::fit::internal
