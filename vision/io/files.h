// Files as they are read: memory maps, little-endian numbers, how large a picture may be, names in messages.
#pragma once

#include <fmt/core.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "vision/picture.h"

namespace tribotrack::vision {

// File names in messages.

inline std::string in_quotes(const std::filesystem::path& path) {
  std::string text(1, '\'');
  text += path.string();
  text += '\'';
  return text;
}

/// Throws InputError: the file's name, then what is wrong with it and what to do.
template <class... Values>
[[noreturn]] void refuse(const std::filesystem::path& file, fmt::format_string<Values...> clause,
                         Values&&... values) {
  throw InputError(in_quotes(file) + " " + fmt::format(clause, std::forward<Values>(values)...));
}

// A file seen as memory.

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
  /// To be called after `length` bytes were copied. Throws InputError when the file has shrunk meanwhile:
  /// zeros would have been read. What was read stays in the system's cache, but counts as memory of this
  /// process only until 128 MiB were read (some 0.4 GB with the pages about them), however large the file.
  void done_with(std::uint64_t length);

 private:
  /// Throws InputError when the file has shrunk.
  void require_unshrunk() const;

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  const std::uint8_t* data_ = nullptr;
  std::uint64_t held_ = 0;  ///< bytes read since they were last let go
};

// Little-endian numbers in the bytes of a file.

static_assert(std::endian::native == std::endian::little, "file readers assume a little-endian machine");

/// The number at `offset`; the bytes must be there.
template <typename Number>
Number load(std::span<const std::uint8_t> bytes, std::size_t offset) {
  Number number;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

template <typename Number>
void store(std::span<std::uint8_t> bytes, std::size_t offset, Number number) {
  std::memcpy(bytes.data() + offset, &number, sizeof number);
}

// How large a picture may be.

/// Several times what any high-speed camera films. A file that states more is damaged, or made to exhaust the
/// memory.
inline constexpr std::int64_t kLongestSide = 32768;
inline constexpr std::int64_t kMostPixels = std::int64_t{1} << 26;

/// Throws InputError, before anything of that size is allocated.
void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height);
/// Also where a packed picture is larger than that many bytes can hold, however they are packed.
void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height,
                           std::uint64_t file_bytes);

}  // namespace tribotrack::vision
