// From a minimum to what is told about it.
#pragma once

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"
#include "fit/uncertainty/covariance.h"

namespace tribotrack::fit::internal {

/// From sd and the two-sided quantile t: on the logarithm's axis or linear, as ParameterEstimate::ci95 says.
Interval interval95(const Transform& transform, FitParameter parameter, double value, double sd, double t);
/// Estimates with sd and ci95 (`t`: the two-sided 95 % quantile of each), covariance, correlation.
void tell_parameters(const Unknowns& unknowns, const Eigen::VectorXd& values, const Uncertainty& uncertainty,
                     const std::vector<double>& t, FitResult& result);
/// Residuals of every run; outlying points named in the warnings.
void tell_runs(const Residuals& residuals, const Minimum& best, FitResult& result);
/// d parameters / d ln A and d ln w, in words.
void tell_systematics(const Residuals& residuals, const Minimum& best, const Uncertainty& uncertainty,
                      FitResult& result);

}  // namespace tribotrack::fit::internal
