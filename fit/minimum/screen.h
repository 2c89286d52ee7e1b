// Where descents begin: a dense sample of the admissible box, judged cheaply.
#pragma once

#include <vector>

#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

struct ScreenedPoint {
  double chi2 = 0;  ///< about: few runs, few digits
  Eigen::VectorXd z;
};

/// Points of the box by Halton's sequence, the guess as number 0: mu1 from 0.05 to 5 of the sliding threshold
/// A w^2/g and mu2 from 0.002 to 1 of mu1 on logarithms, most of them where parts are driven (mu1 from 0.15
/// to 1.6 of the threshold, mu2 from 0.02 to 0.8 mu1), one of ten with mu2 = mu1; tilts +-0.3 deg; A, w and
/// scale +-2 %; twice the sd where there is a prior. The lag of each is not searched but computed, over its
/// full turn: turning the pulses by the lag turns the drift by as much (rotation law), so chi^2 is a
/// trigonometric polynomial of it. Six runs are looked at (keep_representative()); of a trajectory its
/// displacement. `first` points, then twice as many while these show basins worth a descent that those before
/// did not, at most 8000. A point that some of the runs show to lie too high is not judged by the others: its
/// chi^2 is a lower bound.
std::vector<ScreenedPoint> screen(const Residuals& residuals, int threads, std::size_t first);

/// The k-th number of van der Corput's sequence, in (0, 1) for k > 0.
double halton(int k, int base);

/// So many of them: one of every pulse width and drive first, then evenly over the others. The rest leave.
void keep_representative(std::vector<SummaryRun>& runs, std::size_t most);

/// How far above the best point one may lie in chi^2 that has a minimum as low near it: a neighbour in the
/// sample differs by some 10 % in mu1 and mu2, and its displacements by 25 % at most.
double refinable(const Residuals& residuals);

/// Those that are the best within the critical distance of multi-level single linkage (Rinnooy Kan and Timmer
/// 1987) and on their side of the sliding threshold mu1 g = A w^2, across which chi^2 has its ridges: the
/// bottoms of the basins that the sample resolves, best first. None whose chi^2 is above the best by more
/// than `near`.
std::vector<ScreenedPoint> basins(const Unknowns& unknowns, std::vector<ScreenedPoint> points, double near);

}  // namespace tribotrack::fit::internal
