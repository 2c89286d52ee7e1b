// Does the model describe the data?
#pragma once

#include "fit/fit_result.h"

namespace tribotrack::fit::internal {

/// From chi2, dof, p_value and scatter of a result.
Agreement agreement(const FitResult& result);

}  // namespace tribotrack::fit::internal
