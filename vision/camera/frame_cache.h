// Frames decoded once are not decoded again.
//
// A window of a compressed frame costs the decoding of the whole frame, and often of those before it. Where
// a later pass needs it again, the window is kept in an unnamed temporary file on disk, which
// the system writes out as it sees fit: memory does not grow with the recording.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {

// Where frames that were decoded once are kept, and how many bytes all frame caches of this process may use.

/// One account for all caches that write to one folder: several recordings analysed at the same time share
/// the free space, they do not each claim half of it. Thread-safe.
class CacheSpace {
 public:
  static constexpr std::int64_t kMostInMemory = 256'000'000;  ///< bytes, where the folder itself is memory

  /// `free_bytes` states what is free in the folder now; at most `most_bytes` are used in all.
  CacheSpace(std::filesystem::path folder, std::function<std::int64_t()> free_bytes, std::int64_t most_bytes);

  /// That of this process: the temporary folder, or /var/tmp where the former is a file system in memory.
  static CacheSpace& of_this_process();

  const std::filesystem::path& folder() const { return folder_; }
  std::int64_t most_bytes() const { return most_bytes_; }

  /// Whether `bytes` more may be written, which then count as used: never more than half of what was free
  /// before the caches wrote, nor than most_bytes().
  bool take(std::int64_t bytes);
  void give_back(std::int64_t bytes);

 private:
  std::filesystem::path folder_;
  std::function<std::int64_t()> free_bytes_;
  std::int64_t most_bytes_;
  std::mutex mutex_;
  std::int64_t taken_ = 0;
};

/// Whether a folder lies in memory (tmpfs, ramfs).
bool is_in_memory(const std::filesystem::path& folder);

/// The first of the folders that is not in memory and can be written to; the first of all where none is.
std::filesystem::path choose_cache_folder(std::span<const std::filesystem::path> folders);

/// A source that reads from what is kept of another, and the rest from that one. Where the other does not
/// decode (SourceInfo::decoded) nothing is kept. What is handed out is the same bit for bit either way.
class FrameCache : public FrameSource {
 public:
  static constexpr std::int64_t kMostBytes = 4'000'000'000;

  /// Keeps references. At most `most_bytes` in the temporary file, and no more than `space` has left; what
  /// comes later is not kept.
  explicit FrameCache(FrameSource& source, std::int64_t most_bytes = kMostBytes,
                      CacheSpace& space = CacheSpace::of_this_process());
  ~FrameCache() override;
  FrameCache(const FrameCache&) = delete;
  FrameCache& operator=(const FrameCache&) = delete;

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
  CacheSpace& space_;
  int descriptor_ = -1;
  bool keeping_;
  std::int64_t end_ = 0;
  std::unordered_map<std::int64_t, Place> places_;
  Picture picture_;
  std::vector<std::uint8_t> bytes_;
};

using KeptFrames = FrameCache;  // the name in vision/tracker.cpp and vision/layers

}  // namespace tribotrack::vision
