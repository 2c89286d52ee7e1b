// Recordings that libav or OpenCV decode, in a process of their own.
//
// What strangers wrote is decoded where a crash, an endless loop or unbounded memory ends that process, and
// becomes one InputError about one recording. The process may read files and nothing else (confinement.h). It
// also works ahead: while frames are asked for in regular steps, the next ones are decoded meanwhile.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "vision/frame_source.h"
#include "vision/io/levels.h"

namespace tribotrack::vision {

/// A recording whose frames are decoded as wholes, in the process that decodes.
class DecodedSource {
 public:
  virtual ~DecodedSource() = default;
  const SourceInfo& info() const { return info_; }
  /// Decodes a frame. What it gives, and coded(), holds until the next one.
  virtual StoredFrame decode(std::int64_t index) = 0;
  /// How the codec stored that frame; null if that is unknown.
  virtual const CodedFrame* coded() const { return nullptr; }

 protected:
  SourceInfo info_;
};

/// What `open` returns, but decoded in a process of its own. Throws what `open` throws: InputError,
/// std::bad_alloc, any other exception as std::runtime_error; InputError where that process dies.
std::unique_ptr<FrameSource> open_contained(const std::filesystem::path& path,
                                            const std::function<std::unique_ptr<DecodedSource>()>& open);

}  // namespace tribotrack::vision
