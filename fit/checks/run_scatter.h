// Friction that differs from run to run, all of it by the same share: mu1 and mu2 of run i are (1 + e_i) of
// the campaign's, e_i of sd s. With J_i = mu1 dx_i/dmu1 + mu2 dx_i/dmu2 (whitened) its residuals have the
// covariance I + s^2 J_i J_i'; s is that of the greatest likelihood,
//   -2 ln L(s) = sum_i ln(1 + s^2 |J_i|^2) + r_i'r_i - s^2 (J_i'r_i)^2 / (1 + s^2 |J_i|^2).
// It is an explanation like others, by what -2 ln L falls; one against which no closer look at the platform
// helps.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "fit/problem.h"

namespace tribotrack::fit::internal {

struct RunScatter {
  double relative = 0;  ///< s
  double fall = 0;      ///< of -2 ln L from s = 0
  double chi2 = 0;      ///< the quadratic part
};

/// Of the summary runs' rows, two a run; `by_mu` is J. nullopt where none is seen.
std::optional<RunScatter> run_scatter(const Eigen::VectorXd& residuals, const Eigen::VectorXd& by_mu);

/// As an error of each run's own.
Problem with_run_scatter(Problem problem, double relative, double mu1, double mu2);

}  // namespace tribotrack::fit::internal
