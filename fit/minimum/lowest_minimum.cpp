// The minimum of the full model: from those of the search, and elsewhere where the data reject these.
#include <algorithm>
#include <cmath>
#include <vector>

#include "fit/minimum/multi_start.h"
#include "fit/residuals/linear_terms.h"
#include "fit/tools/thresholds.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

/// With the conditions at the means of their priors.
Eigen::VectorXd conditions_as_known(const Unknowns& unknowns, const Eigen::VectorXd& z) {
  Eigen::VectorXd values = unknowns.values(z);
  for (const Eigen::Index i : linear_unknowns(unknowns, true))
    if (const auto known = unknowns.prior(i)) values(i) = known->mean;
  return unknowns.z(values);
}

}  // namespace

Minimum homed_in(Residuals& residuals, const Eigen::VectorXd& z, std::span<const double> shares) {
  constexpr int kSteps = 10;
  constexpr double kShare = 0.03, kCoarsest = 1e-5;  ///< of the integration: of a sigma, of a path
  const ExcessVariance own = residuals.excess_variance();
  const double tolerance = residuals.tolerance();
  const double typical = residuals.unknowns().problem().typical_displacement();
  residuals.set_tolerance(std::max(tolerance, residuals.tolerance_for(kShare, kCoarsest)));
  Minimum there;
  there.z = conditions_as_known(residuals.unknowns(), z);
  for (const double share : shares) {
    ExcessVariance wide = own;
    wide.runs = std::hypot(own.runs, share * typical);
    residuals.set_excess_variance(wide);
    there = descend_in_full(residuals, there.z, {.full_steps = kSteps});
    if (there.at.empty()) break;
  }
  residuals.set_excess_variance(own);
  residuals.set_tolerance(tolerance);
  return there;
}

namespace {

Minimum search_elsewhere(Residuals& residuals, const Minimum& best, const Search& search, int threads) {
  constexpr std::size_t kPlaces = 4, kWhole = 2;
  const Unknowns& unknowns = residuals.unknowns();
  const auto points = basins(unknowns, search.sample, refinable(residuals));
  if (points.empty() || !residuals.linear_in_conditions()) return best;
  std::vector<Minimum> ends(std::min(kPlaces, points.size()));
  parallel_for(ends.size(), threads, [&](std::size_t k) {
    Residuals there = residuals;
    ends[k] = homed_in(there, points[k].z);
  });
  std::erase_if(ends, [&](const Minimum& end) { return end.at.empty() || !admissible(unknowns, end.z); });
  std::ranges::stable_sort(ends, {}, &Minimum::chi2);
  Minimum lowest = best;
  for (std::size_t k = 0; k < std::min(kWhole, ends.size()); ++k) {
    Residuals there = residuals;
    const Minimum whole = minimise_linearised(there, ends[k].z);
    if (!(whole.chi2 < lowest.chi2) || !admissible(unknowns, whole.z)) continue;
    lowest = whole;
    residuals = there;
  }
  return lowest;
}

/// Where there is motion: linear in the conditions the search may have taken them to where there is none.
Eigen::VectorXd linearised_start(Residuals& residuals, const Eigen::VectorXd& z) {
  const Unknowns& unknowns = residuals.unknowns();
  if (residuals.linearise(unknowns.values(z))) return z;
  const Eigen::VectorXd known = conditions_as_known(unknowns, z);
  residuals.linearise(unknowns.values(known));
  return known;
}

}  // namespace

Lowest lowest_minimum(Residuals& residuals, const Search& search, int threads) {
  const Unknowns& unknowns = residuals.unknowns();
  const Eigen::VectorXd first = linearised_start(residuals, search.minima.front().z);
  // Own errors move the displacement by as much as these friction parameters make of them.
  residuals.set_own_errors(unknowns.values(first));
  Lowest lowest{minimise_linearised(residuals, first)};
  // Linear in the conditions the search may take another for the lowest: near the threshold of sliding they
  // are not.
  const auto near = std::min(search.minima.size(), lowest.minimum.far_from_linear ? kRefined : 1);
  for (std::size_t i = 1; i < near; ++i) {
    Residuals there = residuals;
    const Minimum other = minimise_linearised(there, linearised_start(there, search.minima[i].z));
    if (!(other.chi2 < lowest.minimum.chi2) || !admissible(unknowns, other.z)) continue;
    residuals = there;
    lowest = {other, i};
  }
  if (residuals.p_value(lowest.minimum.chi2) < kDoubt)
    lowest.minimum = search_elsewhere(residuals, lowest.minimum, search, threads);
  return lowest;
}

}  // namespace tribotrack::fit::internal
