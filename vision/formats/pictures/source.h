// Image sequences and TIFF stacks as sources of frames.
#pragma once

#include "vision/formats/pictures/names.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

/// One file per frame, all of the size of the first; checked when a frame is read. 8 or 16 bits; colour is
/// handed out as luma. Pictures never state a capture rate: the time base is the user's or unknown.
std::unique_ptr<FrameSource> open_picture_sequence(const std::filesystem::path& path, PictureList pictures,
                                                   const SourceOptions& options);

/// A multi-page TIFF, one page per frame; a single picture is a stack of one.
std::unique_ptr<FrameSource> open_picture_stack(const std::filesystem::path& path,
                                                const SourceOptions& options);

}  // namespace tribotrack::vision
