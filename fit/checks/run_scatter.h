// Friction that differs from run to run: mu1 and mu2 of run i are (1 + e) of the campaign's, both with the
// same e or each with its own, of sd s. With G_i the derivatives of the run's displacement by ln mu1 and
// ln mu2, whitened (their sum for one e), its residuals r_i have the covariance
//   S_i = I + s^2 (G_i G_i' + b^2 tr(G_i G_i')/2 I),
// b the share to which a displacement is linear in so much friction; s is that of the greatest likelihood,
//   -2 ln L(s) = sum_i ln |S_i| + r_i' S_i^-1 r_i.
// It is an explanation like others, by what -2 ln L falls; one against which no closer look at the platform
// helps.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "fit/fit_result.h"
#include "fit/problem.h"
#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

struct RunScatter {
  double relative = 0;    ///< s
  bool together = false;  ///< mu1 and mu2 of a run by the same share: e is one
  double fall = 0;        ///< of -2 ln L from s = 0
  double chi2 = 0;        ///< the quadratic part, with the priors'
  double beyond_any = 0;  ///< `fall` beyond that by a scatter of all displacements alike, m
};

/// Of the summary runs' rows `at` values. nullopt where none is seen.
std::optional<RunScatter> run_scatter(const Residuals& residuals, const Eigen::VectorXd& values,
                                      const Linearised& at);

/// The explanation by it, in per cent, of so many numbers.
Explanation scatter_of(double per_cent, std::size_t numbers);

/// As an error of each run's own, of mu1 and mu2 `together` or each by itself.
Problem with_run_scatter(Problem problem, double relative, bool together, double mu1, double mu2);

}  // namespace tribotrack::fit::internal
