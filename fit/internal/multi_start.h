// Finding the minimum: several descents from a screened box.
#pragma once

#include <vector>

#include "fit/estimate.h"
#include "fit/internal/minimise.h"

namespace tribotrack::fit::internal {

struct Search {
  std::vector<KnownMinimum> minima;  ///< distinct, best first
  int starts = 0;
  int at_best = 0;
};

/// Start 0 is the user's (missing values: the scene's own scale). The others come from a Halton sequence over
/// a box (mu1 from 0.15 to 1.6 of the sliding threshold A w^2/g, mu2 from 0.02 to 0.8 mu1, tilts +-0.3 deg,
/// A, w and scale +-2 %); the lag of each is not searched but computed: turning the pulses by the lag turns
/// the drift by as much (rotation law), so the lag that aligns modelled with measured displacements is a
/// weighted mean angle. The best of the screened points are descended from; a descent that enters the basin
/// of a known minimum stops there.
Search multi_start(const Residuals& residuals, const FitOptions& options);

/// The lag brought into (-pi, pi].
Eigen::VectorXd fold_lag(const Unknowns& unknowns, Eigen::VectorXd z);

}  // namespace tribotrack::fit::internal
