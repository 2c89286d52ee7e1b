// The minimum of the full model: from those of the search, and elsewhere where these are in doubt.
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

Minimum homed_in(Residuals residuals, const Eigen::VectorXd& z, std::span<const double> shares) {
  constexpr int kSteps = 10;
  constexpr double kShare = 0.03, kCoarsest = 1e-5;  ///< of the integration: of a sigma, of a path
  const ExcessVariance own = residuals.excess_variance();
  const double typical = residuals.unknowns().problem().typical_displacement();
  residuals.set_tolerance(std::max(residuals.tolerance(), residuals.tolerance_for(kShare, kCoarsest)));
  Minimum there;
  there.z = conditions_as_known(residuals.unknowns(), z);
  for (const double share : shares) {
    ExcessVariance wide = own;
    wide.runs = std::hypot(own.runs, share * typical);
    for (std::size_t i = 0; share > 0 && i < wide.trajectories.size(); ++i)
      wide.trajectories[i] = {share * typical, static_cast<double>(residuals.track(i).points())};
    residuals.set_excess_variance(wide);
    there = minimise_linearised(residuals, there.z, {.full_steps = kSteps});
    if (there.at.empty()) break;
  }
  return there;
}

namespace {

/// From where the problem that is linear at z has its minimum: that steps over kinks of chi^2.
Minimum minimise_over_kinks(Residuals& residuals, const Eigen::VectorXd& z) {
  const MinimiseOptions rough{.decrement = 0.01, .max_iterations = 40, .patient = false};
  residuals.linearise(residuals.unknowns().values(z));
  return minimise_linearised(residuals, minimise(residuals, z, rough).z);
}

/// Where the best basins of the search lead to, homed in; basins of one valley meet at the first of the
/// shares. Best first.
std::vector<Minimum> ends_of_basins(const Residuals& residuals, const Search& search, int threads) {
  constexpr std::size_t kPlaces = 4;
  const Unknowns& unknowns = residuals.unknowns();
  const std::span<const double> shares(kHomeIn);
  const auto points = basins(unknowns, search.sample, refinable(residuals));
  std::vector<Minimum> ends(std::min(kPlaces, points.size()));
  for (std::size_t k = 0; k < ends.size(); ++k) ends[k].z = points[k].z;
  for (const auto& part : {shares.first(1), shares.subspan(1)}) {
    parallel_for(ends.size(), threads,
                 [&](std::size_t k) { ends[k] = homed_in(residuals, ends[k].z, part); });
    std::ranges::stable_sort(ends, {}, &Minimum::chi2);
    std::vector<Minimum> distinct;
    for (const Minimum& end : ends)
      if (!end.at.empty() && std::ranges::none_of(distinct, [&](const Minimum& better) {
            return same(unknowns, better, end, residuals.excess(better.chi2));
          }))
        distinct.push_back(end);
    ends = std::move(distinct);
  }
  return ends;
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
  const auto take = [&](const Residuals& there, const Minimum& other, std::size_t from) {
    if (!(other.chi2 < lowest.minimum.chi2) || !admissible(unknowns, other.z)) return;
    residuals = there;
    lowest = {other, from};
  };
  // Linear in the conditions the search may take another for the lowest: near the threshold of sliding they
  // are not.
  for (std::size_t i = 1; i < std::min(search.minima.size(), kRefined); ++i) {
    if (!(search.minima[i].chi2 < lowest.minimum.chi2)) break;
    Residuals there = residuals;
    const Minimum other = minimise_linearised(there, linearised_start(there, search.minima[i].z));
    take(there, other, i);
  }
  constexpr std::size_t kManyRuns = 64;  ///< whose kinks average out
  const auto doubtful = [&] {
    return residuals.linear_in_conditions() && unknowns.problem().summary_runs.size() < kManyRuns &&
           residuals.p_value(lowest.minimum.chi2) < kDoubt;
  };
  const auto look_beyond = [&](const Eigen::VectorXd& z) {
    Residuals there = residuals;
    const Minimum beyond = minimise_over_kinks(there, z);
    take(there, beyond, lowest.from);
  };
  if (doubtful()) look_beyond(first);
  if (!doubtful()) return lowest;
  constexpr std::size_t kWhole = 2;
  const std::vector<Minimum> ends = ends_of_basins(residuals, search, threads);
  for (std::size_t k = 0; k < std::min(kWhole, ends.size()); ++k) {
    Residuals there = residuals;
    const Minimum near = minimise_linearised(there, ends[k].z);
    take(there, near, lowest.from);
    look_beyond(ends[k].z);
  }
  return lowest;
}

}  // namespace tribotrack::fit::internal
