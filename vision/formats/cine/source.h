// Phantom .cine recordings as a source of frames.
#pragma once

#include "vision/frame_source.h"

namespace tribotrack::vision {

/// Begins with the mark of a .cine file ("CI" and its header's size)?
bool looks_like_cine(const std::filesystem::path& path);

/// Where its first picture begins, after all tables; 0 where that cannot be read.
std::uint64_t cine_head_bytes(const std::filesystem::path& path);

/// Memory-mapped: reading a window of an unpacked recording touches only the rows of that window. Packed
/// 10-bit pixels are handed out as 12-bit linear levels. Times are the camera's stamp of each image where the
/// file has them, else index / capture rate.
std::unique_ptr<FrameSource> open_cine(const std::filesystem::path& path, const SourceOptions& options);

}  // namespace tribotrack::vision
