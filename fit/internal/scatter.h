// Scatter beyond the data's own sigma.
#pragma once

#include "fit/internal/minimise.h"

namespace tribotrack::fit::internal {

/// Tracking noise is far below what runs differ by. The scatter per axis that makes chi^2 equal to its
/// expectation at the present minimum: one between summary runs, one between the points of each trajectory
/// run, the latter with the correlation time of its residuals (neighbouring points share their error: their
/// number overstates what they tell). Zero where chi^2 does not ask (p >= 0.001).
Scatter estimate_scatter(const Residuals& residuals, const Eigen::VectorXd& values,
                         const Eigen::VectorXd& whitened);

}  // namespace tribotrack::fit::internal
