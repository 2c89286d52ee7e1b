// Intervals by refitting simulated data.
#pragma once

#include <vector>

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

struct Bootstrap {
  std::vector<Interval> ci95;  ///< of the reported parameters
  int converged = 0;           ///< refits used
};

/// Parametric: data drawn from the fitted model with the fit's own covariance (scatter and its correlation
/// included, priors drawn as data), refitted from the minimum; 2.5 and 97.5 % points of the estimates.
/// Where the scatter itself was estimated, each draw's noise is scaled by sqrt(dof/chi^2_dof), which makes
/// the ends Student's as those of the covariance are. Draw k depends on the seed and k alone, not on the
/// threads.
Bootstrap bootstrap(const Residuals& residuals, const Minimum& best, bool scatter_estimated,
                    const FitOptions& options);

}  // namespace tribotrack::fit::internal
