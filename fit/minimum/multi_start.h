// Finding the minimum: several descents from a screened box.
#pragma once

#include <vector>

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

struct Search {
  std::vector<KnownMinimum> minima;  ///< distinct, best first
  int screened = 0;                  ///< points of the box looked at
  int starts = 0;                    ///< descents made
  int at_best = 0;
};

/// Start 0 is the user's first guess, where given. The others are the points of a screened box that are worth
/// a descent (screen.h). The first descent is complete; one that enters the basin of a known minimum stops
/// there, and one that crawls far above it is abandoned. While chi^2 rejects the best minimum (p < 0.001)
/// further points are tried, up to options.multi_starts. All are rough: a tenth of a standard deviation.
Search multi_start(const Residuals& residuals, const FitOptions& options);

/// The lag brought into (-pi, pi].
Eigen::VectorXd fold_lag(const Unknowns& unknowns, Eigen::VectorXd z);

}  // namespace tribotrack::fit::internal
