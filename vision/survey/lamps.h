// Lamps: places of a recording that switch between two levels again and again, all of their pixels at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vision/frame_source.h"
#include "vision/survey.h"

namespace tribotrack::vision {

/// The frames of the first `span` that lamps are looked for in, at most `most`, in rising order. Their
/// distances do not repeat (multiples of the golden section), so that no frequency is missed for being in
/// step with them.
std::vector<std::int64_t> spread_frames(std::int64_t span, int most);

/// Lamps in those frames.
std::vector<SurveyedLamp> find_lamps(FrameSource& source, std::span<const std::int64_t> frames);

}  // namespace tribotrack::vision
