// Methods compared: error against run time, ours and others'. One kind of row for integrators, trackers and
// fits.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "fit/problem.h"

namespace tribotrack::bench {

/// How any of the benchmarks runs.
struct BenchOptions {
  bool quick = false;  ///< few and short cases: a check that it works
  /// Simulated, of each design and noise level of coverage(), 200 unless quick; laboratory() takes a
  /// twentieth, of each fault.
  std::optional<int> campaigns = {};
  int threads = 1;                     ///< over these
  std::filesystem::path program = {};  ///< tribotrack, for bench_vision() to time as a whole command
  std::function<void(int done, int total)> progress = {};
};

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

/// Ours: estimate() as `fit` calls it. Others: one textbook Levenberg-Marquardt from one start, with central
/// differences (relative step 1e-6) through our solver, through a segmented Dormand-Prince at 1e-8, and
/// through the paper's recipe, there also with steps of 1 %: with finer ones its derivatives are noise and it
/// does not arrive. Four campaigns of displacements, the same for all. The error is the rms of mu1's,
/// relative; who ends farther than kSameMinimum from our minimum, or in some campaign nowhere, did not
/// arrive. Details: campaigns, converged, off_minimum_sd, mu2_rms_relative, lag_rms_rad.
Comparison bench_fit(const BenchOptions& options = {});
/// As close to the minimum as matters, in standard deviations.
inline constexpr double kSameMinimum = 1e-3;

struct FitTruth {
  double mu1 = 0, mu2 = 0, lag = 0;
};

/// The 14 runs of model/'s identification table: 8 values of phi at dtau = pi/3, 6 values of dtau at phi = 0,
/// from rest; 1 degree on alpha and 2 % on v, drawn from `seed`.
fit::Problem simulated_campaign(const FitTruth& truth, unsigned seed, double cycles = 20);

// Of sub-pixel tracking, over the grid of what recordings are like, rendered with exactly known truth.

/// A disc (170 grey levels, edge blur 0.7 px) goes round by 3.7 px over a platform (80 grey levels) that goes
/// round by 5.6 px, with a marker; one without texture rests. 8 bits. 125 poses, rendered analytically, come
/// again with new noise. Ours is `track` as users get it, learning included; the peers are
/// told where part and marker lie. The error is the rms over the Cramer-Rao bound with everything but the
/// position known, the time that of one thread a frame. Details: rms_px, bound_px, lost, components (two for
/// each frame that counts) and, of ours, standardised (rms of the errors over their own standard deviations:
/// 1 where these are true) and layered (what the plan chose); of others these are NaN.
Comparison bench_vision(const BenchOptions& options = {});

}  // namespace tribotrack::bench
