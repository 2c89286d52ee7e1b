// The least chi^2 of displacements by looking everywhere: slow, obvious, and without any code of the fit.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "apps/bench/fit/bench.h"
#include "apps/bench/fit/designs.h"
#include "fit/problem.h"

namespace tribotrack::bench {

struct ExhaustiveMinimum {
  double chi2 = 0;
  FitTruth at;
  int looked_at = 0;  ///< points of the grid
  int descents = 0;
};

/// chi^2 = sum r' C^-1 r of the problem's displacements in mu1, mu2 and lag (those and no others fitted,
/// drives alike). On a grid of mu1 from a tenth to ten times the sliding threshold (24 points, logarithmic),
/// mu2/mu1 from 0.005 to 1.5 (12) and the lag's whole turn (36), a Levenberg-Marquardt from every point that
/// none of its 26 neighbours is below, and from `random` others; then a compass search from the best three
/// ends, which no kink stops.
ExhaustiveMinimum exhaustive_minimum(const fit::Problem& problem, int random = 30);

struct SearchBenchOptions {
  int campaigns = 1000;  ///< of 3 to 14 runs at random, both noise levels
  std::uint64_t seed = 20210702;
  int threads = 1;
  std::function<void(int done, int total)> progress;
};

/// Campaign k: 3 + k mod 12 runs.
CoverageCampaign search_campaign(const SearchBenchOptions& options, int index);

struct FoundMinimum {
  double chi2 = 0;
  FitTruth at;
};

/// What estimate()'s search ends in.
FoundMinimum minimum_of_fit(const fit::Problem& problem);

struct SearchOutcome {
  int index = 0, runs = 0;
  FoundMinimum found, least;  ///< by the fit, and by the exhaustive search
  /// By more than a hundredth: no interval changes by as little.
  bool missed() const { return found.chi2 > least.chi2 + 0.01; }
  bool better() const { return found.chi2 < least.chi2 - 0.01; }  ///< the exhaustive search missed it
};

std::vector<SearchOutcome> search_outcomes(const SearchBenchOptions& options = {});

}  // namespace tribotrack::bench
