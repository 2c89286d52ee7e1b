// Phantom .cine recordings as a source of frames.
#pragma once

#include <memory>

#include "vision/frame_sink.h"
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

/// Version 1 (64-bit offsets), laid out as real cameras do: 8 bit and 12 in 16 bottom-up. Images are numbered
/// from 0, stamped k / rate after a fixed date, so that the same frames give the same bytes.
std::unique_ptr<FrameSink> create_cine_sink(const std::filesystem::path& path, const SinkOptions& options);

}  // namespace tribotrack::vision
