// Frames that repeat the one before: a camera or a converter that stored a picture twice.
//
// A repeated frame shows the scene at an earlier time than its own: in the velocity, a step of zero
// followed by one of double length.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {

struct RepeatedFrames {
  std::int64_t looked_at = 0;          ///< frames examined, the first included
  std::vector<std::int64_t> repeated;  ///< indices of frames that repeat the previous picture
  /// Stretches of 4 or more equal pictures, [first, last] indices: a paused recording, or a scene at rest
  /// for which the codec stored "no change". They do not count as repeated.
  std::vector<std::pair<std::int64_t, std::int64_t>> still;
  /// Even and odd rows were recorded at different times: where something moves they differ by half a
  /// frame's motion.
  bool weaved = false;
};

inline constexpr const char* kWeavedFields =
    "is interlaced, by its pictures: the even and the odd rows of its frames were filmed at different times; "
    "film progressively, or make one picture of each field (ffmpeg -vf bwdif=send_field)";

/// Compares every frame with the one before, at most `max_frames` of them from the first on. With camera
/// noise no two pictures are equal, so equal ones are one picture. Lossy compression does not store a
/// repeat as its equal: there it is a frame that differs from the one before far less than its neighbours
/// do, in a motion that continues. Reads forwards.
RepeatedFrames find_repeated_frames(FrameSource& source, std::int64_t max_frames);

/// One sentence for each finding, with the recording's own image numbers; empty where there is none.
std::vector<std::string> findings(const RepeatedFrames& repeats, const FrameSource& source);

}  // namespace tribotrack::vision
