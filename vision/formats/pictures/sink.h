// Writing PNG and TIFF sequences.
#pragma once

#include <memory>

#include "vision/frame_sink.h"

namespace tribotrack::vision {

/// By a printf pattern, numbered from 0; a name without a pattern takes a single picture. 8 bits go into
/// 8-bit files, 10 and 12 bits as they are into 16-bit ones. Pictures of an earlier, longer sequence under
/// the same pattern are removed at close(): the two would read as one.
std::unique_ptr<FrameSink> create_picture_sink(const std::filesystem::path& path, const SinkOptions& options);

}  // namespace tribotrack::vision
