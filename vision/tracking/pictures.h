// Pictures of the first pass for debugging.
#pragma once

#include <vector>

#include "vision/stages/debug_pictures.h"
#include "vision/stages/first_pass_result.h"
#include "vision/tracking/setup.h"

namespace tribotrack::vision {

/// The template.
void show_template(const PartSetup& part, const Picture& first, DebugSink& sink);

/// Window, prediction by the template and residual in each of these frames, which are read again. `track` as
/// the first pass left it.
void show_first_pass(const PartSetup& part, const Picture& first, const FirstPassResult& result,
                     const Track& track, const std::vector<ShownFrame>& frames, FrameSource& source,
                     DebugSink& sink);

}  // namespace tribotrack::vision
