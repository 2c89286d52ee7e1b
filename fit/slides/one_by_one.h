// Free slides, prepared and fitted one by one: each has its own mu1 before a mean is formed.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "fit/fit_result.h"
#include "fit/problem.h"
#include "fit/slides/between_slides.h"
#include "fit/slides/blows.h"

namespace tribotrack::fit::internal {

/// The fit of a problem with one slide in it; with `scatter` of its points beyond their own sigma estimated.
using FitAlone = std::function<FitResult(const Problem&, bool scatter)>;

/// Fits mu1 to every free slide by itself and fills in what prepare_slides() left open. Where the angle is
/// seen, spin and friction are found in turn until the spin settles; the problem's slides keep it. A
/// slide that contradicts what is told of its errors (p < 0.001) keeps their size alone, TrackTable::slow
/// cleared.
void fit_one_by_one(Problem& problem, const FitAlone& fit_alone, int threads,
                    std::vector<SlideResult>& slides);

/// The slides with a viscous part each, and how they differ; nullopt where a constant friction describes
/// every one of them, or fewer than two determine both.
struct ViscousSlides {
  std::vector<SlideResult> slides;
  BetweenSlides mu1, viscous;
};
std::optional<ViscousSlides> fit_viscous(const Problem& problem, const FitAlone& fit_alone, int threads,
                                         const std::vector<SlideResult>& constant);

/// nullopt where mu1 is not fitted to at least two slides that determine it.
std::optional<BetweenSlides> compare_slides(const Problem& problem, const std::vector<SlideResult>& slides);

/// Cuts each free slide's track to its longest stretch without a blow and takes a first value of its spin
/// from the angle where that is seen and not given. Returns one entry for each free slide, in order: its
/// name, blows and spin. Throws DataError for one that shows no sliding.
std::vector<SlideResult> prepare_slides(Problem& problem);

/// Of a part that gains speed: from where it is let go to where it is fastest, before it meets whatever ends
/// its way. Of one that loses speed: all that was given, for guess_free_slide() finds its onset.
Stretch sliding_stretch(const TrackTable& track);

/// The direction of the motion, against it where the part was pushed up (slope < 0). A unit vector.
Eigen::Vector2d downhill_of(const TrajectoryRun& run);

}  // namespace tribotrack::fit::internal
