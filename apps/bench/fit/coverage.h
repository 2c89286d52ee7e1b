// Do 95 % intervals hold the truth 95 % of the time? Simulated campaigns with known truth.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "fit/problem.h"

namespace tribotrack::bench {

struct CoverageOptions {
  int campaigns = 1000;
  std::uint64_t seed = 20210701;  ///< of truths and noise; campaign k depends on seed and k alone
  bool profiles = true;
  int threads = 1;
  std::function<void(int done, int total)> progress;
};

/// One campaign: its data and its truth.
struct CoverageCampaign {
  fit::Problem problem;
  std::vector<double> truth;  ///< in the order of problem.free, SI
  bool slipping = true;       ///< mu1 g < A w^2: never sticks; else it may stop between the pulses
  bool tilted = false;        ///< an unknown tilt, fitted
};

/// 14 runs from rest, 20 cycles: 8 values of phi at one dtau, 6 values of dtau at one phi. mu1 drawn from
/// [0.07, 0.108] (slipping, three of five) or [0.116, 0.128] (sticking), mu2/mu1 from [0.05, 0.3], the lag
/// from [-0.5, 0.5]; in every other campaign a tilt with components of 0.1 deg sd. Displacements by a
/// segmented Dormand-Prince integrator (peers/baselines.h), which shares nothing with the one that fits; each
/// with independent errors of 1 % of its length along and across, given as its covariance.
CoverageCampaign coverage_campaign(std::uint64_t seed, int index);

/// Counts of one kind of campaign and one parameter.
struct CoverageRow {
  std::string kind;       ///< "slipping", "slipping, tilt fitted", "sticking", ..., "all"
  std::string parameter;  ///< as in campaigns
  int campaigns = 0;      ///< identifiable ones (verdict identifiable or weak): those counted below
  int weak = 0;           ///< of them, with the verdict weak
  int unusable = 0;       ///< not identifiable or not converged: counted apart
  int covered = 0;        ///< by ci95
  int covered_by_profile = 0;
  double share() const { return campaigns > 0 ? double(covered) / campaigns : 0; }
  double profile_share() const { return campaigns > 0 ? double(covered_by_profile) / campaigns : 0; }
};

std::vector<CoverageRow> coverage(const CoverageOptions& options = {});

}  // namespace tribotrack::bench
