// Methods compared: error against run time, ours and others'. One kind of row for integrators, trackers and
// fits.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "fit/problem.h"

namespace tribotrack::bench {

/// What one benchmark knows of its rows besides, named as in its CSV.
struct Detail {
  const char* name;
  double value;
};

/// One method at one setting on one scene.
struct ComparedRow {
  std::string group;  ///< of scenes: a line of the summary, a panel of the figure
  std::string scene;  ///< rows of one scene are set against each other
  std::string method, setting;
  bool ours = false;    ///< as users get it
  bool arrived = true;  ///< false: it gave up, or ended elsewhere
  double error = 0;     ///< in the comparison's unit
  double time = 0;      ///< s, CPU time
  std::vector<Detail> details = {};

  double at(std::string_view name) const {
    for (const Detail& detail : details)
      if (detail.name == name) return detail.value;
    throw std::out_of_range("no such detail of a benchmark's row");
  }
};

/// What one benchmark compares.
struct Comparison {
  std::string name;         ///< "model", "vision", "fit"
  std::string title;        ///< of the figure
  std::string error, unit;  ///< what the error is of, and its unit
  std::string time;         ///< what is timed
  std::string reference;    ///< where the truth comes from
  /// The summary names the fastest with no larger error (infinite: of all that arrive); 0: the most accurate.
  double target = 0;
  std::vector<ComparedRow> rows = {};
};

/// A group of scenes in one line, medians over its scenes. Plain text.
struct SummaryLine {
  std::string measured, ours;
  std::string peer;  ///< the best of the others
  std::string who;   ///< wins where
};
std::vector<SummaryLine> summary_of(const Comparison& comparison);

// Error against run time of the fit, ours and what others do: simulated campaigns with known truth.
// Measurements of this machine now: the times, not the estimates, change from call to call.

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
