// What the slides show, in words.
#pragma once

#include "fit/fit_result.h"
#include "fit/slides/between_slides.h"

namespace tribotrack::fit::internal {

/// The sentence of each slide; warnings of blows and of slides that differ by more than chance; what a spin
/// not seen would change; and what the covariance counts. `between` is null where mu1 was not fitted to two
/// slides at least.
void describe_slides(const BetweenSlides* between, FitResult& result);

}  // namespace tribotrack::fit::internal
