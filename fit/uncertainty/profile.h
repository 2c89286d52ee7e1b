// Profile likelihood over all valleys: the interval to quote.
//
// The values that the data allow are { z : chi^2(z) <= chi^2_min + rise }, which may be several regions
// apart; the interval of a parameter is the projection of all of them on its axis, in one piece or more.
// Every region has a minimum of its own, so following the constrained minimum outwards from each minimum that
// lies low enough, and from any point of the screened box that turns out to lie in none of the pieces found,
// gives them all.
#pragma once

#include <optional>
#include <vector>

#include "fit/minimum/minimise.h"
#include "fit/minimum/screen.h"

namespace tribotrack::fit::internal {

struct Profile {
  std::vector<Interval> pieces;           ///< ascending, apart from each other
  std::vector<ProfilePoint> points = {};  ///< that were looked at, ascending
  std::optional<Minimum> better;          ///< a point below the minimum: the fit must start again from there
};

/// Of each reported parameter: where min over all other unknowns of chi^2 is within its rise of
/// `minima.front()` (3.84 for 95 %), every point re-optimised from its neighbour's solution. Ends that are
/// not reached within the parameter's range (half a turn for the lag, a factor of ten for scales, mu up to
/// 10) are infinite; 0 for a mu that may be 0. Pieces of the lag lie within half a turn of the estimate. The
/// `open` ones have no ends. A point below the minimum restarts all from there (three times at most);
/// `minima.front()` is then the better one.
std::vector<Profile> profiles(const Residuals& residuals, std::vector<Minimum>& minima,
                              const std::vector<ScreenedPoint>& sample, const std::vector<bool>& open,
                              const std::vector<double>& rises, int threads);

}  // namespace tribotrack::fit::internal
