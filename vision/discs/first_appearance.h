// The part's first appearance: a recording may start before the part is there.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "vision/discs/disc_detection.h"
#include "vision/frame_source.h"
#include "vision/track.h"

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

// A disc that was found by itself and rests while others move may not be the part.

/// Several discs that may be the part, in one frame.
struct DiscQuestion {
  std::int64_t index = 0;     ///< of the frame in the source
  std::int64_t rested = 0;    ///< frames for which the one tracked rests at first
  std::vector<Circle> discs;  ///< that one first, where it is in this frame
};

/// Frames at the beginning of the track in which the part stays where it was, to half a pixel.
std::int64_t frames_at_rest(const Track& track);

/// Looks at four frames of the recording where the disc tracked rests for a twentieth of it or longer at
/// first: nothing where it is the only one of its kind in all of them or, should it rest for ever, nothing
/// else round turns up. `track` begins with frame `first` of the source; `find` finds discs in a picture.
std::optional<DiscQuestion> question_of_rest(FrameSource& source, std::int64_t first, const Track& track,
                                             const std::function<std::vector<DiscFit>(const Picture&)>& find);

}  // namespace tribotrack::vision
