// Writing Phantom .cine recordings.
#pragma once

#include <memory>

#include "vision/frame_sink.h"

namespace tribotrack::vision {

/// Version 1 (64-bit offsets), laid out as real cameras do: 8 bit and 12 in 16 bottom-up. Images are numbered
/// from 0, stamped k / rate after a fixed date, so that the same frames give the same bytes.
std::unique_ptr<FrameSink> create_cine_sink(const std::filesystem::path& path, const SinkOptions& options);

}  // namespace tribotrack::vision
