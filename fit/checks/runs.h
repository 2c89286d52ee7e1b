// What single runs show: which does not belong to the others, and how they differ.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "fit/fit_result.h"
#include "fit/minimum/minimise.h"
#include "fit/problem.h"

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

/// P of `drop` in chi^2 by leaving out a run, when the rest has `rest` at `dof` degrees of freedom.
double chance_of_run(double drop, double rest, double dof);

/// The run without which chi^2 falls most, to first order, and by how much; `out`: those that do not count.
/// 0: no other run checks any.
std::pair<std::size_t, double> worst_run(const Unknowns& unknowns, const Minimum& best,
                                         const std::vector<bool>& out);

/// Do the residuals of neighbouring runs go together, as they do under a wrong model?
/// p of so few changes of sign, along and across the displacements, among summary runs sorted by dtau and phi
/// (Wald and Wolfowitz, Ann. Math. Stat. 11, 147, 1940). 1 with fewer than eight runs.
double runs_test(const std::vector<RunResult>& runs);
/// Likewise of the residuals of summary runs, m.
struct InOrder {
  double width, phi;  ///< rad, of the run's pulse
  Eigen::Vector2d modelled, difference;
};
double runs_test(std::vector<InOrder> runs);

}  // namespace tribotrack::fit::internal
