// Pictures a person checks a track by.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "vision/frame_source.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

/// .png: the trajectory over the first analysed frame. .mp4 / .avi / .mkv: every analysed frame with outline,
/// path so far, frame number and status. Throws InputError.
void write_overlay(FrameSource& source, const TrackResult& result, const std::filesystem::path& path);

/// First analysed frame as an 8-bit grey PNG, in memory (for reports), stretched to full range.
std::vector<unsigned char> first_frame_png(FrameSource& source, std::int64_t frame_number);

}  // namespace tribotrack::vision
