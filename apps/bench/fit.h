// Error against run time of the fit, ours and what others do: simulated campaigns with known truth.
// Measurements of this machine now: the times, not the estimates, change from call to call.
#pragma once

#include <functional>

#include "apps/bench/comparison.h"
#include "fit/problem.h"

namespace tribotrack::bench {

struct FitBenchOptions {
  bool quick = false;  ///< a campaign of short runs: a check that it works
  std::function<void(int done, int total)> progress;
};

/// Ours: estimate() as `fit` calls it. Others: one textbook Levenberg-Marquardt from one start, with central
/// differences (relative step 1e-6) through our solver, through a segmented Dormand-Prince at 1e-8, and
/// through the paper's recipe, there also with steps of 1 %: with finer ones its derivatives are noise and it
/// does not arrive. Four campaigns of displacements, the same for all. The error is the rms of mu1's,
/// relative; who ends farther than kSameMinimum from our minimum, or in some campaign nowhere, did not
/// arrive. Details: campaigns, converged, off_minimum_sd, mu2_rms_relative, lag_rms_rad.
Comparison bench_fit(const FitBenchOptions& options = {});
/// As close to the minimum as matters, in standard deviations.
inline constexpr double kSameMinimum = 1e-3;

struct FitTruth {
  double mu1 = 0, mu2 = 0, lag = 0;
};

/// The 14 runs of model/'s identification table: 8 values of phi at dtau = pi/3, 6 values of dtau at phi = 0,
/// from rest; 1 degree on alpha and 2 % on v, drawn from `seed`.
fit::Problem simulated_campaign(const FitTruth& truth, unsigned seed, double cycles = 20);

}  // namespace tribotrack::bench
