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

/// The run without which chi^2 falls most, to first order, and by how much; `out`: those that do not count.
/// 0: no other run checks any.
std::pair<std::size_t, double> worst_run(const Unknowns& unknowns, const Minimum& best,
                                         const std::vector<bool>& out);

/// Friction that differs from run to run, all of it by the same share: mu1 and mu2 of run i are (1 + e_i) of
/// the campaign's, e_i of sd s. With J_i = mu1 dx_i/dmu1 + mu2 dx_i/dmu2 (whitened) its residuals have the
/// covariance I + s^2 J_i J_i'; s is that of the greatest likelihood,
///   -2 ln L(s) = sum_i ln(1 + s^2 |J_i|^2) + r_i'r_i - s^2 (J_i'r_i)^2 / (1 + s^2 |J_i|^2).
/// It is an explanation like others, by what -2 ln L falls; one against which no closer look at the platform
/// helps.
struct RunScatter {
  double relative = 0;  ///< s
  double fall = 0;      ///< of -2 ln L from s = 0
  double chi2 = 0;      ///< the quadratic part
};

/// Of the summary runs' rows, two a run; `by_mu` is J. nullopt where none is seen.
std::optional<RunScatter> run_scatter(const Eigen::VectorXd& residuals, const Eigen::VectorXd& by_mu);

/// As an error of each run's own.
Problem with_run_scatter(Problem problem, double relative, double mu1, double mu2);

/// Do the residuals of neighbouring runs go together, as they do under a wrong model?
/// p of so few changes of sign, along and across the displacements, among summary runs sorted by dtau and phi
/// (Wald and Wolfowitz, Ann. Math. Stat. 11, 147, 1940). 1 with fewer than eight runs.
double runs_test(const std::vector<RunResult>& runs);

}  // namespace tribotrack::fit::internal
