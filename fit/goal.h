// How well parameters are to be known, and which run brings that nearest: when to stop filming.
#pragma once

#include <vector>

#include "fit/fit_result.h"

namespace tribotrack::fit {

/// Half the width of a parameter's 95 % interval, as a share of its value, or in its own unit (SI).
struct Goal {
  FitParameter parameter = FitParameter::mu1;
  double half_width = 0;
  bool relative = false;
};

/// Half the width of the interval to quote over the goal: reached at 1 and below. Infinity where the interval
/// is open. Throws DataError for a parameter that was not fitted.
double ratio_to(const Goal& goal, const FitResult& result);

/// Whether a usable fit has reached all of them. No goals are never reached.
bool all_reached(const std::vector<Goal>& goals, const FitResult& result);

/// Of the runs that the fit suggests with the drive as it is, the one whose worst ratio of predicted half
/// width to goal is least. Without goals, the best for all parameters. Null where the fit suggests none.
const NextExperiment* next_for(const std::vector<Goal>& goals, const FitResult& result);

}  // namespace tribotrack::fit
