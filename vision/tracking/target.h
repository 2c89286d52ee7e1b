// Where the part is in the frame in which its tracking begins, and which frame that is: a recording may start
// before the part is there, and a disc that was found by itself and rests while others move may not be it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vision/discs/disc_detection.h"
#include "vision/stages/stages.h"

namespace tribotrack::vision {

/// The circle given by the user, fitted to the rim; nothing where that is not seen nearly all the way round.
std::optional<DiscFit> refined(const Picture& first, const Circle& given);
/// Throws InputError where the circle reaches out of the picture.
void check_whole(const Picture& first, const Circle& c, const FrameSource& source, const char* what);
/// The gate's lamp is round and bright, too.
void leave_out_lamp(std::vector<DiscFit>& found, const TrackOptions& options);

/// The frame in which the part is first seen.
struct Appearance {
  std::int64_t index = 0;
  std::vector<DiscFit> discs = {};  ///< that may be the part there, best first; none where none was fitted
  std::optional<std::string> warning = {};  ///< a given disc is not there at first
};
/// Range.first where it is not seen at all, or need not be a disc. Throws InputError for a given disc that is
/// not there while another one is.
Appearance first_appearance(FrameSource& source, const FrameRange& range, const TrackOptions& options);
/// Of the frames first .. last (indices) the first in which any disc is found (after the first frame, with
/// room about it), by steps of a hundredth of the recording and then back by halves: a part that stays is
/// found in its first frame, one that is there for less than such a step may be missed. Frame `first` without
/// discs where there is none.
Appearance arrival_anywhere(FrameSource& source, std::int64_t first, std::int64_t last, DiscSearch search);

/// The part, where its place is not given: away from a given marker, which is round too, and the largest of
/// the discs that are supported nearly as well as the best. `first` is the picture in which they are seen.
/// Throws InputError where no disc is found, AmbiguousTarget where others are like it.
DiscFit find_part(const Picture& first, const FrameSource& source, const Appearance& seen,
                  const TrackOptions& options);

/// Looks at four frames of the recording where the part was found by itself and rests for a twentieth of it
/// or longer at first. Throws AmbiguousTarget unless it is the only one of its kind in all of them and,
/// should it rest for ever, nothing else round turns up. `track` begins with frame `start` of the source,
/// where the part is seen as `part`.
void ask_if_it_rests(FrameSource& source, std::int64_t start, const Track& track, const DiscFit& part,
                     const TrackOptions& options);

}  // namespace tribotrack::vision
