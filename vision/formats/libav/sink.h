// Writing video files: FFV1, MJPEG, H.264.
#pragma once

#include <memory>

#include "vision/frame_sink.h"

namespace tribotrack::vision {

/// FFV1 (lossless; 8, 10 or 12 bits; .mkv or .avi), MJPEG (8 bits; .avi or .mkv), H.264 (8 bits; .mp4, .mkv).
/// The time base is one over the frame rate, which MP4 keeps exactly. Matroska rounds timestamps to 1 ms and
/// keeps the rate beside them. AVI as libav writes it states 600 Hz for all rates beyond 1000 Hz, which no
/// reader here believes: such a recording needs --fps. MJPEG and H.264 hold luma in full range with neutral
/// chroma.
std::unique_ptr<FrameSink> create_libav_sink(const std::filesystem::path& path, const SinkOptions& options);

}  // namespace tribotrack::vision
