// What others do with a recording on disk, from opening it to its last frame. Each runs as a process of its
// own (`tribotrack bench-peer`, which --help does not list), so that whole commands are compared.
#pragma once

#include <filesystem>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::bench {

/// How far a windowed search goes from the last position, px: several times what moves in these recordings.
inline constexpr int kSearch = 8;

/// Follows each target (the part, then the mark) by cv::matchTemplate in a window about its last position,
/// with a parabola between pixels; the template is its square in the first frame. `targets` are given where
/// they lie in the first frame, to the fraction of a pixel. Returns the positions of the first one, px.
std::vector<vision::Point> follow_by_matching(const std::filesystem::path& recording,
                                              const std::vector<vision::Circle>& targets);

/// Reads the windows that follow_by_matching() would, from the targets' first places, and nothing else. What
/// is coded is decoded for it.
void read_windows(const std::filesystem::path& recording, const std::vector<vision::Circle>& targets);

}  // namespace tribotrack::bench
