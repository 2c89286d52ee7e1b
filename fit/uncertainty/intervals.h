// 95 % intervals from standard deviations.
#pragma once

#include "fit/fit_result.h"
#include "fit/residuals/transform.h"

namespace tribotrack::fit::internal {

/// From the sd and the two-sided quantile t: value exp(-+ t sd/value) on the axis of the logarithm, value -+
/// t sd on a linear one, which of the two as ParameterEstimate::ci95 states.
Interval interval95(const Transform& transform, FitParameter parameter, double value, double sd, double t);

}  // namespace tribotrack::fit::internal
