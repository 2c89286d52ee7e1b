// Which run does not belong to the others.
#pragma once

#include "fit/estimate.h"
#include "fit/fit_result.h"
#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

/// The run that contradicts the others most is looked for, left out, and so on while there is one. First each
/// is judged to first order: without it chi^2 falls by
///   D = r'(1 - H)^-1 r,  H = J_i (J'J)^-1 J_i'  (deleted residual of two components);
/// then the fit is made again without the worst, and D compared with what is left, F = (D/2)/(chi^2 - D)
/// (dof - 2) (externally studentised; where the rest agrees with its sigma, with the sigma instead). It is
/// named when so large a D has a chance below 1 % among all runs. Where turning its pulse by an angle would
/// bring it back (rotation law), the phi it looks like is reported, too. `residuals` without scatter and
/// weights, `best` their minimum.
std::vector<Outlier> find_outliers(Residuals residuals, Minimum best);

}  // namespace tribotrack::fit::internal
