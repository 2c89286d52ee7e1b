// The rotation of the part in every frame in which it was found, where its texture shows it.
#pragma once

#include "vision/frame_source.h"
#include "vision/stages/first_pass_result.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// Fills the points' rotation: of a disc by its rings about the centres of the track (rotation_track.h), of a
/// rectangle as its template was registered. A disc's template is not asked: under a lamp that stands still
/// it sees a turning disc turn less, and says it knows. Nothing where the first frame shows no texture.
/// `plan` is told of the rings.
void measure_rotation(FrameSource& source, const FirstPassResult& first, Track& track,
                      std::vector<PlanStage>& plan, int threads = 1);

}  // namespace tribotrack::vision
