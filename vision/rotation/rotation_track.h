// The rotation of a disc through a recording, its centre known in every frame, with its standard deviation.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/frame_source.h"
#include "vision/stages/first_pass_result.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// One per frame, 0 in the first; nothing where the disc's inside does not look like before. Empty where that
/// holds for most frames, or no rotation can be seen.
///
/// The variance is that of the harmonics' scatter, and what grows with the angle turned as the learnt picture
/// is renewed: from how the angles by the inner and the outer rings, each learnt for itself, drift apart. The
/// same for any number of threads.
std::vector<std::optional<Rotation>> follow_rotation(FrameSource& source,
                                                     const std::vector<FirstPassFrame>& frames, double radius,
                                                     double blur, int threads = 1);

// The rotation of the part in every frame in which it was found, where its texture shows it.

/// Fills the points' rotation: of a disc by its rings about the centres of the track (rotation_track.h), of a
/// rectangle as its template was registered. A disc's template is not asked: under a lamp that stands still
/// it sees a turning disc turn less, and says it knows. Nothing where the first frame shows no texture.
/// `plan` is told of the rings.
void measure_rotation(FrameSource& source, const FirstPassResult& first, Track& track,
                      std::vector<PlanStage>& plan, int threads = 1);

}  // namespace tribotrack::vision
