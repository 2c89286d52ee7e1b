// What has been decoded once is not decoded again.
//
// A window of a compressed frame costs the decoding of the whole frame, and often of those before it. Where
// a later pass will look again, its window is kept in a nameless temporary file, which the system writes out
// as it sees fit: memory does not grow with the recording.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {

/// A source that answers from what is kept of another, and asks that one for the rest. Where the other does
/// not decode (SourceInfo::decoded) nothing is kept. What is handed out is the same bit for bit either way.
class KeptFrames : public FrameSource {
 public:
  static constexpr std::int64_t kMostBytes = 4'000'000'000;

  /// Keeps a reference. `most_bytes` in the temporary file, and never more than half of the disk's free
  /// space; what comes later is not kept.
  explicit KeptFrames(FrameSource& source, std::int64_t most_bytes = kMostBytes);
  ~KeptFrames() override;
  KeptFrames(const KeptFrames&) = delete;
  KeptFrames& operator=(const KeptFrames&) = delete;

  using FrameSource::read;
  void read(std::int64_t index, const Rect& window, Picture& picture) override;

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
  bool open_file();
  bool read_back(const Place& place, const Rect& window, Picture& picture);
  void give_up();

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
