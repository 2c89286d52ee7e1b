// Profile likelihood: the reference for intervals.
#pragma once

#include <optional>
#include <vector>

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"

namespace tribotrack::fit::internal {

struct Profile {
  Interval interval;
  std::optional<Minimum> better;  ///< a point below the minimum: the fit must start again from there
};

/// Where min over all other unknowns of chi^2 has risen by `rise` (3.84 for 95 %) on both sides of the
/// minimum, every point re-optimised from its neighbour's solution. Ends that are not reached within the
/// parameter's range (half a turn for the lag, a factor of ten for scales, mu up to 10) are infinite; 0 for a
/// mu that may be 0.
Profile profile(const Residuals& residuals, const KnownMinimum& best, Eigen::Index parameter, double rise);

/// Profiles of all reported parameters but the `open` ones, whose intervals have no ends. A point below the
/// minimum restarts them from there (three times at most); `best` is then the better minimum.
std::vector<Interval> profiles(const Residuals& residuals, KnownMinimum& best, const std::vector<bool>& open,
                               const std::vector<double>& rises, int threads);

}  // namespace tribotrack::fit::internal
