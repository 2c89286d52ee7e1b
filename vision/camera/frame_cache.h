// Frames decoded once are not decoded again.
//
// A window of a compressed frame costs the decoding of the whole frame, and often of those before it. Where
// a later pass needs it again, the window is kept in an unnamed temporary file on disk, which
// the system writes out as it sees fit: memory does not grow with the recording.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {

/// A source that reads from what is kept of another, and the rest from that one. Where the other does not
/// decode (SourceInfo::decoded) nothing is kept. What is handed out is the same bit for bit either way.
class FrameCache : public FrameSource {
 public:
  static constexpr std::int64_t kMostBytes = 4'000'000'000;
  static constexpr std::int64_t kLeftFree = 1'000'000'000;  ///< bytes of the disk

  /// Keeps a reference. At most `most_bytes` in the temporary file, in the folder TMPDIR names, else /var/tmp
  /// (which is no memory); what comes later, or would leave less than kLeftFree there, is not kept.
  explicit FrameCache(FrameSource& source, std::int64_t most_bytes = kMostBytes);
  ~FrameCache() override;
  FrameCache(const FrameCache&) = delete;
  FrameCache& operator=(const FrameCache&) = delete;

  void fill(std::int64_t index, const Rect& window, Picture& picture) override;

  /// Keeps a window of a frame: best the one read last. Replaces a smaller one; nothing where it is kept
  /// already.
  void keep(std::int64_t index, const Rect& window);

  std::int64_t kept_bytes() const { return end_; }

 private:
  struct Place {
    Rect window;
    std::int64_t offset = 0;
    int bytes = 1;  ///< of a level: whole ones up to 255, up to 65535, or any
  };
  const Place* find(std::int64_t index, const Rect& window) const;
  bool append();
  bool read_back(const Place& place, const Rect& window, Picture& picture);

  FrameSource& source_;
  std::int64_t most_bytes_;
  int descriptor_ = -1;
  bool keeping_;
  std::int64_t end_ = 0;
  std::unordered_map<std::int64_t, Place> places_;
  Picture picture_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace tribotrack::vision
