// Where descents begin: a sampled box, judged cheaply.
#pragma once

#include <vector>

#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

struct ScreenedPoint {
  double chi2 = 0;  ///< about: few runs, few digits
  Eigen::VectorXd z;
  bool worth_a_descent = true;
};

/// Points of a box (mu1 from 0.15 to 1.6 of the sliding threshold A w^2/g, mu2 from 0.02 to 0.8 mu1, tilts
/// +-0.3 deg, A, w and scale +-2 %, twice the sd where there is a prior) by Halton's sequence, the guess as
/// number 0. The lag of each is not searched but computed: turning the pulses by the lag turns the drift by
/// as much (rotation law), so the lag that aligns modelled with measured displacements is a weighted mean
/// angle. One run of every pulse width and drive is looked at, six at most; of a trajectory its displacement.
std::vector<ScreenedPoint> screen(const Residuals& residuals, int count, int threads);

/// Multi-level single linkage (Rinnooy Kan and Timmer 1987): a sampled point is worth a descent unless a
/// better one lies within the critical distance and on the same side of the sliding threshold mu1 g = A w^2,
/// across which chi^2 has its ridges. Those first, best first; then the others, best first.
std::vector<ScreenedPoint> worth_a_descent(const Unknowns& unknowns, std::vector<ScreenedPoint> points);

}  // namespace tribotrack::fit::internal
