// What a fit says of motions that were not filmed, with a limit on the work: for curves in reports.
#pragma once

#include "fit/problem.h"

namespace tribotrack::fit {

/// predicted_displacement (problem.h) in at most `max_steps` steps of the model: friction next to nothing
/// takes thousands of cycles to settle. Throws model::StepLimitExceeded where that is not enough, and
/// model::InvalidParameter for a scenario without a motion.
Displacement predicted_displacement(const model::Scenario& fitted, const FittedParameters& known,
                                    long max_steps);

}  // namespace tribotrack::fit
