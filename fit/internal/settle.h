// Minimum, scatter and robust weights, which depend on each other.
#pragma once

#include "fit/estimate.h"
#include "fit/internal/minimise.h"

namespace tribotrack::fit::internal {

/// Descends from `best`, estimates scatter and weights there, and again, until neither moves: a few rounds.
/// On return the residuals carry both.
void settle(Residuals& residuals, Minimum& best, bool with_scatter, Loss loss);

bool any(const Scatter& scatter);

}  // namespace tribotrack::fit::internal
