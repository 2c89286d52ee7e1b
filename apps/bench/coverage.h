// Do 95 % intervals hold the truth 95 % of the time? Simulated campaigns of every design (campaigns.h).
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "apps/bench/campaigns.h"
#include "fit/fit_result.h"

namespace tribotrack::bench {

struct CoverageOptions {
  int campaigns = 200;  ///< of each design and level
  /// Of truths and noise: campaign k depends on design, level, seed and k alone.
  std::uint64_t seed = 20210701;
  int threads = 1;  ///< over campaigns
  std::function<void(int done, int total)> progress;
};

/// Counts of one design, level and parameter.
struct CoverageRow {
  Design design = Design::both_sweeps;
  NoiseLevel level = NoiseLevel::low;
  std::string parameter;  ///< as in campaigns
  int campaigns = 0;
  int usable = 0;   ///< verdict identifiable or weak: those counted below
  int weak = 0;     ///< of them, with the verdict weak
  int open = 0;     ///< of them, with an interval infinite on a side, or the whole turn of a lag
  int covered = 0;  ///< of them, by the quoted interval, open ones included
  double share() const { return usable > 0 ? double(covered) / usable : 0; }
  fit::Interval share_ci95() const;  ///< Clopper and Pearson's
};

/// Fits with profiles and blind starts, as `fit` does. Rows in the order of kDesigns and kNoiseLevels.
std::vector<CoverageRow> coverage(const CoverageOptions& options = {});

/// What was quoted for a parameter: its interval, or its pieces where minima lie apart.
std::vector<fit::Interval> quoted_pieces(const fit::ParameterEstimate& parameter);
/// Does one of the pieces hold this value? A lag (`turns`) is known modulo a turn.
bool holds(const std::vector<fit::Interval>& pieces, double value, bool turns);

/// The exact 95 % interval of a probability after `hits` of `trials` (Clopper and Pearson 1934).
fit::Interval binomial_ci95(int hits, int trials);

}  // namespace tribotrack::bench
