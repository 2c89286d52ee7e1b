// Least squares with Ceres: friction parameters, their uncertainty, and what the data cannot determine.
//
//   Problem problem;                                     // fit/problem.h
//   problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
//   problem.summary_runs = ...;                          // displacements; or trajectory_runs: tracked points
//   const FitResult result = estimate(problem, {.threads = 8});
//   std::puts(result.full_report().c_str());             // fit/fit_result.h
//
// Minimised is chi^2(theta) = sum r_i' C_i^-1 r_i + sum ((theta_k - m_k)/s_k)^2: r_i = measured - modelled
// displacement of run i (or position of point i) with covariance C_i, then the priors. The model is eq. (5)
// of the paper with exact derivatives by theta = (mu1, mu2, phase lag, ...).
//
// A small chi^2 is no proof that theta is unique: with one drive and one dtau, mu1 trades against the lag
// (rotation law). Read FitResult::identifiability before quoting numbers.
#pragma once

#include <functional>

#include "fit/fit_result.h"
#include "fit/problem.h"

namespace tribotrack::fit {

struct FitOptions {
  int threads = 1;  ///< over runs and starts; at least 1. The result does not depend on it.
  /// Descents at most, at least 1. Start 0 is Problem::start, the others are the basins of a densely screened
  /// box, the deepest first; six of them where tracks are fitted. 1: no screening.
  int multi_starts = 24;
  bool profiles = true;         ///< profile likelihood intervals: most of the time of a fit
  bool next_experiment = true;  ///< look for the run to film next
  /// Estimate errors beyond the data's own sigma and count them in the covariance: scatter between runs or
  /// points where chi^2 rejects the fit (p < 0.001; between runs p < 0.05), and correlated errors of driven
  /// tracks, which chi^2 does not see. False: the covariance rests on the data's sigma alone.
  bool estimate_scatter = true;
  Loss loss = Loss::squares;  ///< huber: outlying displacements are down-weighted; no profiles then
  bool rivals =
      false;  ///< compare tilt and alternative friction laws even where the residuals do not require it
  int bootstrap = 0;  ///< refits to simulated data; 0: none, 400 give the ends of intervals to about 10 %
  unsigned bootstrap_seed = 1;  ///< of their noise; recorded in the result
  /// Asked where chi^2 rejects the fit: whether something was mistyped (fit/slips.h). Then nothing else is
  /// looked for that explains the residuals.
  std::function<bool(const FitResult& assumed)> mistyped = {};
  /// Progress callback, from one thread at a time: stages are "starts", "bootstrap", ...
  std::function<void(const char* stage, std::size_t done, std::size_t total)> progress = {};

  /// Throws std::invalid_argument naming the option.
  void validate() const;
};

/// What finds the minimum: "Ceres 2.1.0".
const char* solver();

/// Fits. Throws DataError, model::InvalidParameter (a run that has no motion) or std::invalid_argument (an
/// option). A fit that is not identifiable returns (usable() == false) with what can be determined.
FitResult estimate(const Problem& problem, const FitOptions& options = {});

}  // namespace tribotrack::fit
