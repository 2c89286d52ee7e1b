// What free slides need before they are fitted.
#pragma once

#include <vector>

#include "fit/fit_result.h"
#include "fit/problem.h"

namespace tribotrack::fit::internal {

/// Cuts each free slide's track to its longest stretch without a blow and takes a first value of its spin
/// from the angle where that is seen and not given. Returns one entry for each free slide, in order: its
/// name, blows and spin. Throws DataError for one that shows no sliding.
std::vector<SlideResult> prepare_slides(Problem& problem);

}  // namespace tribotrack::fit::internal
