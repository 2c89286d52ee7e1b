// Where the part is in the frame in which its tracking begins, and which frame that is.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/discs/disc_detection.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

struct FrameRange {
  std::int64_t first = 0, last = 0;  ///< indices, both included
};

/// A click made exact by the rim where it supports it; nothing, and a warning, where it does not.
std::optional<DiscFit> refined(const Picture& first, const Circle& given, const char* what,
                               TrackSummary& summary);
/// Throws InputError where the circle reaches out of the picture.
void check_whole(const Picture& first, const Circle& c, const FrameSource& source, const char* what);
/// The lamp is round and bright, too.
void leave_out_lamp(std::vector<DiscFit>& found, const TrackOptions& options);
/// Where the recording starts before the part is there: the frame it is first seen in. Range.first where it
/// is not seen at all, or need not be a disc.
std::int64_t arrival(FrameSource& source, const FrameRange& range, const TrackOptions& options);
/// The part, where the user does not say where it is: away from a given marker, which is round too, and the
/// largest of what is supported nearly as well as the best.
DiscFit find_part(const Picture& first, const FrameSource& source, const TrackOptions& options);

}  // namespace tribotrack::vision
