// Where the part is in the frame in which its tracking begins, and which frame that is.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/discs/disc_detection.h"
#include "vision/stages/frame_range.h"

namespace tribotrack::vision {

/// The circle given by the user, fitted to the rim; nothing where no rim supports it.
std::optional<DiscFit> refined(const Picture& first, const Circle& given);
/// Throws InputError where the circle reaches out of the picture.
void check_whole(const Picture& first, const Circle& c, const FrameSource& source, const char* what);
/// The gate's lamp is round and bright, too.
void leave_out_lamp(std::vector<DiscFit>& found, const TrackOptions& options);
/// The frame in which the part is first seen, where the recording starts before that. Range.first where it is
/// not seen at all, or need not be a disc.
std::int64_t first_appearance(FrameSource& source, const FrameRange& range, const TrackOptions& options);
/// The part, where its place is not given: away from a given marker, which is round too, and the largest of
/// the discs that are supported nearly as well as the best. Throws InputError where no disc is found.
DiscFit find_part(const Picture& first, const FrameSource& source, const TrackOptions& options);

}  // namespace tribotrack::vision
