// Where frames that were decoded once are kept, and how many bytes all frame caches of this process may use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <span>

namespace tribotrack::vision {

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

}  // namespace tribotrack::vision
