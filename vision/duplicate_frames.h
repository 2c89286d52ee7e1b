// Frames that repeat the one before: a camera or a converter that stored a picture twice.
//
// A repeated frame shows the scene at an earlier time than its own and shows up in a velocity as a step of
// zero followed by a double one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {

struct RepeatedFrames {
  std::int64_t looked_at = 0;          ///< frames examined, the first included
  std::vector<std::int64_t> repeated;  ///< indices of frames that show the picture before once more
  /// Stretches of 4 and more equal pictures, [first, last] indices: a paused recording, or a scene at rest
  /// whose coder wrote "nothing changed". They do not count as repeated.
  std::vector<std::pair<std::int64_t, std::int64_t>> still;
  /// Even and odd rows were filmed at different times: where something moves they differ as half a frame
  /// does.
  bool weaved = false;
};

inline constexpr const char* kWeavedFields =
    "is interlaced, by its pictures: the even and the odd rows of its frames were filmed at different times; "
    "film progressively, or make one picture of each field (ffmpeg -vf bwdif=send_field)";

/// Compares every frame with the one before, at most `max_frames` of them from the first on. A camera's noise
/// makes two pictures of even the same scene differ, so equal ones are one picture. A coder does not store
/// a repeat as its equal: there it is what differs far less than the frames before and after, in a motion
/// that goes on. Reads forwards.
RepeatedFrames find_repeated_frames(FrameSource& source, std::int64_t max_frames);

/// One sentence for each finding, with the recording's own image numbers; empty where there is none.
std::vector<std::string> findings(const RepeatedFrames& repeats, const FrameSource& source);

}  // namespace tribotrack::vision
