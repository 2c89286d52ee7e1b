// Refits of many drawn sets of displacements at once.
#pragma once

#include <vector>

#include "fit/uncertainty/curved_residuals.h"

namespace tribotrack::fit::internal {

struct DisplacementRefit {
  Eigen::VectorXd z;   ///< the drawn data's minimum, or where to look for it
  bool found = false;  ///< false: a descent is to find it
};

/// `drawn` are the problem of `residuals`, which has no trajectory runs, with other measured displacements
/// and means of priors; covariances stay. Each minimum comes from the second order about `best` and is
/// confirmed by one simulation of every run, all of them side by side.
std::vector<DisplacementRefit> refit_displacements(const Residuals& residuals, const Minimum& best,
                                                   const CurvedResiduals& curved,
                                                   const std::vector<Problem>& drawn, int threads);

/// Share of the sigma by which the integrator may err there.
inline constexpr double kRefitTolerance = 1e-3;

}  // namespace tribotrack::fit::internal
