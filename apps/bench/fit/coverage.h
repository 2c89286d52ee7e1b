// Do 95 % intervals hold the truth 95 % of the time, and are they no wider than they must be? Simulated
// campaigns of every design (designs.h).
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "apps/bench/fit/designs.h"
#include "apps/bench/fit/quoted_interval.h"

namespace tribotrack::bench {

struct CoverageOptions {
  int campaigns = 200;       ///< of each design and level
  int of_trajectories = 50;  ///< and of Design::trajectories, whose fits take seconds
  std::uint64_t seed =
      20210701;  ///< of truths and noise: campaign k depends on design, level, seed and k alone
  std::vector<Design> designs{kDesigns.begin(), kDesigns.end()};
  std::vector<NoiseLevel> levels{kNoiseLevels.begin(), kNoiseLevels.end()};
  /// Every parts-th of all these campaigns, the part-th first: what one of several jobs does.
  std::size_t part = 1, parts = 1;
  int threads = 1;  ///< over campaigns
  std::function<void(int done, int total)> progress;
};

/// What one fit said of its parameters.
struct JudgedCampaign {
  bool usable = false, weak = false;
  std::vector<JudgedInterval> parameters;
  std::string failure;  ///< of a fit that threw
};

/// Fits with profiles and blind starts, as `fit` does.
JudgedCampaign judge(const CoverageCampaign& campaign);

/// One parameter of one campaign.
struct JudgedParameter {
  Design design = Design::both_sweeps;
  NoiseLevel level = NoiseLevel::low;
  int campaign = 0;
  std::string parameter;  ///< as in campaigns
  bool fitted = false;    ///< false: the fit threw
  bool usable = false, weak = false;
  JudgedInterval interval = {};
  /// That of the campaigns of one call: by design and level as in kDesigns and kNoiseLevels, then campaign.
  friend bool operator<(const JudgedParameter& a, const JudgedParameter& b) {
    return std::tie(a.design, a.level, a.campaign) < std::tie(b.design, b.level, b.campaign);
  }
};

/// Counts of one design, level and parameter.
struct CoverageRow {
  Design design = Design::both_sweeps;
  NoiseLevel level = NoiseLevel::low;
  std::string parameter;
  int campaigns = 0;
  int usable = 0;          ///< verdict identifiable or weak: those counted below
  int weak = 0;            ///< of them, with the verdict weak
  int open = 0;            ///< of them, with an interval infinite on a side
  int covered = 0;         ///< of them, by the quoted interval, open ones included
  int covered_of_all = 0;  ///< of all campaigns, whatever the verdict
  double score = 0;  ///< mean of JudgedInterval::score of the usable ones: what an open one costs is in it
  double share() const { return usable > 0 ? double(covered) / usable : 0; }
  double share_of_all() const { return campaigns > 0 ? double(covered_of_all) / campaigns : 0; }
  fit::Interval share_ci95() const;  ///< Clopper and Pearson's
};

/// In order.
std::vector<JudgedParameter> judged_campaigns(const CoverageOptions& options = {});
/// From campaigns in order, of one part or of all.
std::vector<CoverageRow> coverage_of(const std::vector<JudgedParameter>& judged);

/// The exact 95 % interval of a probability after `hits` of `trials` (Clopper and Pearson 1934).
fit::Interval binomial_ci95(int hits, int trials);

}  // namespace tribotrack::bench
