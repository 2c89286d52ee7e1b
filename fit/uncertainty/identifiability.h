// What the data can and cannot determine.
#pragma once

#include <vector>

#include "fit/uncertainty/covariance.h"

namespace tribotrack::fit::internal {

/// not_identifiable: a parameter moves no observable (dead), a direction is flat, a profile is open, or mu2
/// lies above mu1; where no profile was computed, an sd that exceeds the range the parameter can have (not
/// pinned) or pulses that may have no effect. weak: a relative sd above 0.3, an interval in pieces, or a
/// profile that reaches more than twice as far as the covariance (the minimum sits in a bend of a flat
/// valley). A trade-off (|correlation| > 0.95) is told; the intervals contain it.
Identifiability identifiability(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                const Uncertainty& uncertainty,
                                const std::vector<ParameterEstimate>& parameters);

/// Parameters that a flat direction moves: their sd is infinite.
std::vector<bool> moved_by_flat_direction(const Uncertainty& uncertainty);

}  // namespace tribotrack::fit::internal
