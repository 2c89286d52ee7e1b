// Which run to film next.
#pragma once

#include <optional>
#include <vector>

#include "fit/estimate.h"
#include "fit/uncertainty/covariance.h"

namespace tribotrack::fit::internal {

struct NextExperiments {
  /// With the drive of the runs so far: shrinks the volume of the parameters' ellipsoid most (D-criterion;
  /// ranges stand in for what is not pinned at all).
  std::optional<NextExperiment> best;
  /// With that drive, for each parameter alone (c-criterion), where another run than `best` serves it better;
  /// then the best with another A or w for the ellipsoid and for each parameter, where it shortens the
  /// standard deviations by another tenth.
  std::vector<NextExperiment> others;
  bool given_up = false;  ///< it took too many steps: neither is told
};

/// Over a grid of phi (by pi/4), dtau (by pi/4), A and w (the runs' own, one of them by 0.8 or 1.25).
/// Bounded: by the steps of all integrations (about a second), and by 50 times those of the runs so far for a
/// candidate. `t`: the two-sided 95 % quantile of the intervals. Empty without driven runs.
NextExperiments next_experiments(const Residuals& residuals, const Eigen::VectorXd& values,
                                 const Linearised& at, double t, const FitOptions& options);

}  // namespace tribotrack::fit::internal
