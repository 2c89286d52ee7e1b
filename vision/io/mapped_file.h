// A file seen as memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace tribotrack::vision {

/// Throws InputError in one sentence when `path` is not a readable, non-empty regular file.
void require_readable_file(const std::filesystem::path& path);

/// Read-only memory map. Only the pages touched are read from disk. A file that another program cuts short
/// while it is being read would end the process by a signal on the next touch, so every access checks the
/// file's present size first; only a cut within the microseconds between question and touch escapes that.
class MappedFile {
 public:
  /// Throws InputError: missing, a directory, empty, not readable.
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  /// `length` bytes from `offset`. Throws InputError naming `what` when the file ends before, or has shrunk
  /// since it was opened.
  std::span<const std::uint8_t> bytes(std::uint64_t offset, std::uint64_t length,
                                      std::string_view what) const;
  /// The same after require_unshrunk() has just been called.
  std::span<const std::uint8_t> bytes_unasked(std::uint64_t offset, std::uint64_t length,
                                              std::string_view what) const;
  /// Throws InputError when the file has shrunk: to be called after copying, which would have read zeros.
  void require_unshrunk() const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  const std::uint8_t* data_ = nullptr;
};

}  // namespace tribotrack::vision
