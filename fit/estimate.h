// Least squares with Ceres: friction parameters, their uncertainty, and what the data cannot tell.
#pragma once

#include <functional>

#include "fit/fit_result.h"
#include "fit/problem.h"

namespace tribotrack::fit {

struct FitOptions {
  int threads = 1;       ///< over runs and starts; Ceres itself runs on one
  int multi_starts = 8;  ///< the user's start is number 0
  bool profiles = true;
  bool next_experiment = true;  ///< look for the run to film next
  /// Scatter between points or runs beyond their own sigma is estimated from the residuals when chi-square
  /// asks for it (p < 0.001), and added to the covariance; FitResult::scatter says so. So are slow errors of
  /// driven tracks, whatever chi-square says: it does not see them (FitResult::slow_errors).
  bool estimate_scatter = true;
  Loss loss = Loss::squares;
  bool rivals = false;          ///< compare tilt and rival friction laws even where the residuals do not ask
  int bootstrap = 0;            ///< refits to simulated data; 0: none, 400 give the ends to about 10 %
  unsigned bootstrap_seed = 1;  ///< of its noise; told in the result
  /// Told how far each stage is ("starts", "bootstrap", ...), by one thread at a time.
  std::function<void(const char* stage, std::size_t done, std::size_t total)> progress;
};

/// Fits. Throws DataError or model::InvalidParameter. A fit that is not identifiable returns (usable() ==
/// false) with what can be told.
FitResult estimate(const Problem& problem, const FitOptions& options = {});

}  // namespace tribotrack::fit
