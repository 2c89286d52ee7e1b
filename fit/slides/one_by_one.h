// Free slides one by one: each has its own mu1 before a mean is formed.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "fit/fit_result.h"
#include "fit/problem.h"
#include "fit/slides/between_slides.h"

namespace tribotrack::fit::internal {

/// The fit of a problem with one slide in it.
using FitAlone = std::function<FitResult(const Problem&)>;

/// Fits mu1 to every free slide by itself and fills in what prepare_slides() left open. Where the angle is
/// seen, spin and friction are found in turn until the spin settles; the problem's slides keep it. A
/// slide that contradicts what is told of its errors (p < 0.001) keeps their size alone, TrackTable::slow
/// cleared.
void fit_one_by_one(Problem& problem, const FitAlone& fit_alone, int threads,
                    std::vector<SlideResult>& slides);

/// nullopt where mu1 is not fitted to at least two slides that determine it.
std::optional<BetweenSlides> compare_slides(const Problem& problem, const std::vector<SlideResult>& slides);

}  // namespace tribotrack::fit::internal
