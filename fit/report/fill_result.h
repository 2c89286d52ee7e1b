// From a minimum to the fields of a FitResult.
#pragma once

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"
#include "fit/residuals/residuals.h"
#include "fit/uncertainty/covariance.h"
#include "fit/uncertainty/profile.h"

namespace tribotrack::fit::internal {

/// Estimates with sd and ci95 (`t`: the two-sided 95 % quantile of each), covariance, correlation.
void fill_parameters(const Unknowns& unknowns, const Eigen::VectorXd& values, const Uncertainty& uncertainty,
                     const std::vector<double>& t, FitResult& result);
/// Residuals of every run; a warning names outlying points.
void fill_runs(const Residuals& residuals, const Minimum& best, FitResult& result);
/// The profile, and whether it is the interval to quote.
void fill_profile(const Profile& profile, double level, ParameterEstimate& estimate);
/// Of the runs that were held out: the fit's own covariance of what it says of them is part of their
/// residuals' sd.
void fill_predictions(const Residuals& residuals, const Minimum& best, const Uncertainty& uncertainty,
                      FitResult& result);
/// Departures from the paper's law of friction that were set free, or that the data show by three sds: a
/// warning, and mu1 against speed.
void fill_laws(const Unknowns& unknowns, const Eigen::VectorXd& values, const Uncertainty& uncertainty,
               FitResult& result);
/// All minima near the best, the lag folded; the best with its final values first.
void fill_minima(const Residuals& residuals, const std::vector<Minimum>& minima, FitResult& result);

// The errors that the covariance counts: numbers and sentences.

/// Scatter of runs and points, and which covariance is printed. `allowed`: a scatter could have been
/// estimated.
void fill_excess_variance(const Residuals& residuals, bool allowed, FitResult& result);
/// Correlated errors of driven tracks. After fill_excess_variance().
void fill_correlated_errors(const Residuals& residuals, FitResult& result);

}  // namespace tribotrack::fit::internal
