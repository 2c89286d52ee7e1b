// Image sequences and TIFF stacks as sources and sinks of frames.
#pragma once

#include <memory>

#include "vision/formats/pictures/names.h"
#include "vision/frame_sink.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

// Image sequences and TIFF stacks as sources of frames.

/// One file per frame, all of the size of the first; checked when a frame is read. 8 or 16 bits; colour is
/// handed out as luma. Pictures never state a capture rate: the time base is the user's or unknown.
std::unique_ptr<FrameSource> open_picture_sequence(const std::filesystem::path& path, PictureList pictures,
                                                   const SourceOptions& options);

/// A multi-page TIFF, one page per frame; a single picture is a stack of one.
std::unique_ptr<FrameSource> open_picture_stack(const std::filesystem::path& path,
                                                const SourceOptions& options);

// Writing PNG and TIFF sequences.

/// By a printf pattern, numbered from 0; a name without a pattern takes a single picture. 8 bits go into
/// 8-bit files, 10 and 12 bits as they are into 16-bit ones. Pictures of an earlier, longer sequence under
/// the same pattern are removed at close(): the two would read as one.
std::unique_ptr<FrameSink> create_picture_sink(const std::filesystem::path& path, const SinkOptions& options);

}  // namespace tribotrack::vision
