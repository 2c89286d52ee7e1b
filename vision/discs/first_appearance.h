// The part's first appearance: a recording may start before the part is there.
#pragma once

#include <cstdint>
#include <optional>

#include "vision/discs/disc_detection.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

/// The first of the frames first .. last (indices) in which a disc's rim is seen at the given place, up to
/// `capture` px off. In the first frame, where the user has placed it, any rim will do that goes nearly all
/// the way round; a later one must be as clear as DiscSearch requires. Reads no more than the window about
/// it.
std::optional<std::int64_t> arrival_at(FrameSource& source, std::int64_t first, std::int64_t last,
                                       const Circle& place, double capture);

/// The first in which any disc is found (find_discs; after the first frame, with room about it), by steps of
/// a hundredth of the recording and then back by halves: a part that stays is found in its first frame, one
/// that is there for less than such a step may be missed.
std::optional<std::int64_t> arrival_anywhere(FrameSource& source, std::int64_t first, std::int64_t last,
                                             const DiscSearch& search);

}  // namespace tribotrack::vision
