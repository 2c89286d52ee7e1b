// Anything libav decodes as a source of frames, at its native depth.
#pragma once

#include <memory>

#include "vision/frame_sink.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

/// All packets are listed at opening without decoding them, so that frame_count is what the file holds and
/// frame k is the k-th shown; a file cut short is an InputError there, a damaged frame one at read(). Luma is
/// handed out as stored, RGB as 0.299 R + 0.587 G + 0.114 B.
std::unique_ptr<FrameSource> open_libav(const std::filesystem::path& path, const SourceOptions& options);

/// FFV1 (lossless; 8, 10 or 12 bits; .mkv or .avi), MJPEG (8 bits; .avi or .mkv), H.264 (8 bits; .mp4, .mkv).
/// The time base is one over the frame rate, which MP4 keeps exactly. Matroska rounds timestamps to 1 ms and
/// keeps the rate beside them. AVI as libav writes it states 600 Hz for all rates beyond 1000 Hz, which no
/// reader here believes: such a recording needs --fps. MJPEG and H.264 hold luma in full range with neutral
/// chroma.
std::unique_ptr<FrameSink> create_libav_sink(const std::filesystem::path& path, const SinkOptions& options);

}  // namespace tribotrack::vision
