// Finding the minimum: several descents from a screened box.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "fit/estimate.h"
#include "fit/minimum/minimise.h"
#include "fit/minimum/screen.h"

namespace tribotrack::fit::internal {

/// Of so many runs a search looks at all.
inline constexpr std::size_t kRunsToSearch = 24;
/// Minima of a search that are looked at in the full model where it decides which is the lowest.
inline constexpr std::size_t kRefined = 4;

struct Search {
  std::vector<ScreenedPoint> sample;  ///< of the whole box; empty where a single start was wanted
  std::vector<Minimum> minima;        ///< distinct, best first
  int starts = 0;                     ///< descents made
  int at_best = 0;
};

/// Start 0 is the user's first guess, where given. The others are the basins of a screened box (screen.h).
/// The first descent is complete; one that enters the basin of a known minimum stops there, and one that
/// crawls far above it is abandoned. All are rough: a tenth of a standard deviation. A minimum with mu2 >
/// mu1, a pulse that raises friction, does not count unless there is no other.
Search multi_start(const Residuals& residuals, const FitOptions& options);

/// The lowest minimum of the full model that a search leads to, with `residuals` linearised there.
struct Lowest {
  Minimum minimum;
  std::size_t from = 0;  ///< of Search::minima, the one that led to it
};

/// From the best minimum of the search, and from others that it has lower than what that leads to. Where p of
/// chi^2 is below 0.05, and runs are so few that kinks of chi^2 do not average out, from the best basins it
/// screened as well, homed in: the search itself has displacements linear in the conditions; where these are
/// far from what is known of them and errors are small it ends in a valley from which no descent leads out.
Lowest lowest_minimum(Residuals& residuals, const Search& search, int threads);

/// The same campaign with what its driven tracks moved over whole cycles in their place: two numbers a run.
/// One without a whole turn stays a track.
Problem by_displacements(Problem problem);

/// The minima of driven tracks, each from one of their displacements, whose lowest is at `place`.
struct DisplacementSearch {
  Search search;
  Eigen::VectorXd place;
};
DisplacementSearch search_by_displacements(const Residuals& residuals, const FitOptions& options);

/// From z, first as if the model were good to a tenth of a typical displacement, then better and better: what
/// is fitted finds its valley while the conditions stay near what is known of them, and these take their part
/// as it is asked for. The minimum at the last of the shares, to a few per cent of a standard deviation;
/// no motion there: Minimum::at is empty.
inline constexpr std::array kHomeIn{0.1, 0.03, 0.01, 0.003, 0.0};
Minimum homed_in(Residuals residuals, const Eigen::VectorXd& z, std::span<const double> shares = kHomeIn);

/// Within half a standard deviation of each other; standard deviations widened by the residuals (`spread` =
/// chi^2/dof).
bool same(const Unknowns& unknowns, const Minimum& a, const Minimum& b, double spread);

/// Pulses lower friction: mu2 <= mu1.
bool admissible(const Unknowns& unknowns, const Eigen::VectorXd& z);

/// The lag brought into (-pi, pi].
Eigen::VectorXd fold_lag(const Unknowns& unknowns, Eigen::VectorXd z);

}  // namespace tribotrack::fit::internal
