// A disc that was found by itself and rests while others move may not be the part.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "vision/discs/disc_detection.h"
#include "vision/frame_source.h"
#include "vision/track.h"

namespace tribotrack::vision {

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
