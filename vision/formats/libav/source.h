// Anything libav decodes as a source of frames, at its native depth.
#pragma once

#include "vision/frame_source.h"

namespace tribotrack::vision {

/// All packets are listed at opening without decoding them, so that frame_count is what the file holds and
/// frame k is the k-th shown; a file cut short is an InputError there, a damaged frame one at read(). Luma is
/// handed out as stored, RGB as 0.299 R + 0.587 G + 0.114 B.
std::unique_ptr<FrameSource> open_libav(const std::filesystem::path& path, const SourceOptions& options);

}  // namespace tribotrack::vision
