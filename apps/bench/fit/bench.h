// Error against run time of the fit, ours and what others do: simulated campaigns with known truth.
// Measurements of this machine now: the times, not the estimates, change from call to call.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "fit/problem.h"

namespace tribotrack::bench {

struct FitBenchOptions {
  bool quick = false;  ///< few campaigns of short runs: a check that it works
  std::function<void(int done, int total)> progress;
};

/// mu1, mu2, lag.
struct FitTruth {
  double mu1 = 0, mu2 = 0, lag = 0;
};

/// The 14 runs of model/'s identification table: 8 values of phi at dtau = pi/3, 6 values of dtau at phi = 0,
/// from rest; 1 degree on alpha and 2 % on v, drawn from `seed`.
fit::Problem simulated_campaign(const FitTruth& truth, unsigned seed, double cycles = 20);

/// The same runs point by point: `points` of each, evenly spaced over the cycles, with 1e-6 m of noise per
/// axis.
fit::Problem simulated_tracks(const FitTruth& truth, unsigned seed, std::size_t points = 2000,
                              double cycles = 20);

/// One method over all campaigns of one kind. Vectors hold mu1 and mu2 relative to the truth, and the lag in
/// rad.
struct FitBenchRow {
  std::string data;  ///< "14 displacements", "14 tracks"
  std::string method;
  bool ours = false;
  int campaigns = 0;
  int converged = 0;
  double time = 0;    ///< s per campaign, CPU time of one thread, median
  double solves = 0;  ///< trajectories solved per campaign, mean; 0 where not counted
  Eigen::Vector3d rms_error = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_sd = Eigen::Vector3d::Zero();
  Eigen::Vector3d covered = Eigen::Vector3d::Zero();  ///< share of 95 % intervals that hold the truth
  /// Farthest any estimate lies from that of "tribotrack" on the same campaign, in its standard deviations.
  double off_minimum = 0;
  double time_over_ours = 0;  ///< over "tribotrack"'s time on the same data
};

/// Ours: estimate() as `fit` calls it (8 starts and the search for the next run), with profiles, and from one
/// start. Beside it one Levenberg-Marquardt from the same start with exact derivatives, with central
/// differences (relative step 1e-6) through our solver, through a segmented Dormand-Prince at 1e-8
/// (displacements only), and through the paper's recipe (few campaigns: it is slow), there also with steps of
/// 1 %: with finer ones its derivatives are noise and it does not arrive. 40 campaigns of displacements,
/// three of tracks with 2000 points a run.
std::vector<FitBenchRow> bench_fit(const FitBenchOptions& options = {});

}  // namespace tribotrack::bench
