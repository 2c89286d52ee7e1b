// Where the part is in the frame in which its tracking begins, and which frame that is.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
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
/// The frame in which the part is first seen.
struct Appearance {
  std::int64_t index = 0;
  std::optional<std::string> warning;  ///< a given disc is not there at first
};
/// Range.first where it is not seen at all, or need not be a disc. Throws InputError for a given disc that is
/// not there while another one is.
Appearance first_appearance(FrameSource& source, const FrameRange& range, const TrackOptions& options);
/// All that may be the part, best first; `beside_best` as in DiscSearch.
std::vector<DiscFit> discs_in(const Picture& picture, const TrackOptions& options, double beside_best = 0);
/// The part, where its place is not given: away from a given marker, which is round too, and the largest of
/// the discs that are supported nearly as well as the best. `first` is frame `index`. Throws InputError where
/// no disc is found, AmbiguousTarget where others are like it.
DiscFit find_part(const Picture& first, const FrameSource& source, std::int64_t index,
                  const TrackOptions& options);

/// Throws AmbiguousTarget where the part was found by itself and rests while others move
/// (first_appearance.h). `track` begins with frame `start` of the source, where the part is seen as `disc`.
void ask_if_it_rests(FrameSource& source, std::int64_t start, const Track& track, const Circle& disc,
                     const TrackOptions& options);

}  // namespace tribotrack::vision
