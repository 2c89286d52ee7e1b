// Covariance from the whitened sensitivity at the minimum, intervals from it, what each run does to the
// estimates; and intervals by refitting simulated data.
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "fit/estimate.h"
#include "fit/fit_result.h"
#include "fit/minimum/minimise.h"
#include "fit/residuals/residuals.h"
#include "fit/tools/transform.h"

namespace tribotrack::fit::internal {

/// The information on the reported parameters with all others (scale as a nuisance, initial velocities)
/// marginalised, by the singular values of the whitened sensitivity in natural units.
struct Uncertainty {
  Eigen::MatrixXd covariance;       ///< of the reported parameters, SI; flat directions left out
  Eigen::MatrixXd shared;           ///< covariance of all unknowns that runs share, likewise
  Eigen::VectorXd singular_values;  ///< falling
  Eigen::MatrixXd directions;       ///< columns: right singular vectors, in natural units
  Eigen::VectorXd units;            ///< natural units of the reported parameters
  Eigen::Index rank = 0;
  Eigen::VectorXd column_norms;  ///< how strongly each parameter alone moves the data
};

/// A direction weaker than 1e-9 of the strongest is flat.
Uncertainty uncertainty(const Unknowns& unknowns, const Eigen::VectorXd& values, const Linearised& at);

/// The change of each reported parameter (columns) if a run (rows: summary runs, then trajectory runs) were
/// left out, in standard deviations of the parameter: to first order (J'J - J_i'J_i)^-1 J_i' r_i with J_i,
/// r_i the run's whitened rows, its own unknowns eliminated [Belsley, Kuh and Welsch, Regression Diagnostics,
/// 1980, section 2.1]. NaN where the others alone do not determine it.
Eigen::MatrixXd influence_of_runs(const Residuals& residuals, const Minimum& best,
                                  const Uncertainty& uncertainty);

/// From the sd and the two-sided quantile t: value exp(-+ t sd/value) on the axis of the logarithm, value -+
/// t sd on a linear one, which of the two as ParameterEstimate::ci95 states.
Interval interval95(const Transform& transform, FitParameter parameter, double value, double sd, double t);

/// Reported parameters with intervals by the normal distribution; `covariance`: theirs first.
std::map<FitParameter, EstimateUnder> estimates_under(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                                      const Eigen::MatrixXd& covariance);

// Intervals by refitting simulated data.

struct Bootstrap {
  std::vector<Interval> ci95;  ///< of the reported parameters
  int converged = 0;           ///< refits used
};

/// Parametric: data drawn from the fitted model with the fit's own covariance (scatter and its correlation
/// included, priors drawn as data), refitted from the minimum; 2.5 and 97.5 % points of the estimates. Drawn
/// are the whitened errors e, independent numbers: r(z) - r(minimum) + e are the residuals of such data.
/// Where the scatter itself was estimated, each draw's noise is scaled by sqrt(dof/chi^2_dof), which makes
/// the ends Student's as those of the covariance are. Draw k depends on the seed and k alone, not on the
/// threads.
Bootstrap bootstrap(const Residuals& residuals, const Minimum& best, bool scatter_estimated,
                    const FitOptions& options);

}  // namespace tribotrack::fit::internal
