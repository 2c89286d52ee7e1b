// What the data can and cannot determine.
#pragma once

#include <vector>

#include "fit/estimate.h"
#include "fit/uncertainty/covariance.h"

namespace tribotrack::fit::internal {

/// not_identifiable: a parameter moves no observable (dead), a direction is flat, or an sd exceeds the range
/// the parameter can have (not pinned). weak: |correlation| > 0.95 (trade-off), or a relative sd above 0.3.
Identifiability identifiability(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                const Uncertainty& uncertainty);

/// Where a profile reaches more than twice as far as the covariance the likelihood is far from a parabola
/// (the minimum sits in a bend of a flat valley): weak, with a sentence.
void compare_with_profiles(const Unknowns& unknowns, const std::vector<ParameterEstimate>& parameters,
                           Identifiability& result);

/// Parameters that a flat direction moves: their sd is infinite.
std::vector<bool> moved_by_flat_direction(const Uncertainty& uncertainty);

/// Beyond this sd a parameter is not pinned.
double range(const Unknowns& unknowns, FitParameter parameter, const Eigen::VectorXd& values);

}  // namespace tribotrack::fit::internal
