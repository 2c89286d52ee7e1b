// Files that appear whole or not at all.
//
//   TemporaryFile file("table.csv");
//   file.write("x,y\n1,2\n");
//   file.commit();
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "vision/picture.h"

namespace tribotrack::vision {

/// A file that cannot be written: no room, no permission. Whatever was to be written next would fare no
/// better.
class OutputError : public InputError {
 public:
  using InputError::InputError;
};

/// A file of another name beside `target`, where nothing was; commit() renames it to `target`. Destroyed
/// without commit(), it is removed, as remove_partial_files() does with all of them. Where `target` is a
/// symbolic link, the file that it leads to is written, and the link stays. A file that is written anew keeps
/// its mode and, where that is allowed, its owner.
class TemporaryFile {
 public:
  /// In ".NAME.partial-PID-RANDOM", which no reader takes for a recording: what killed processes left can be
  /// told by their number.
  static constexpr std::string_view kMark = ".partial-";

  /// Throws OutputError where no file can be made there (and so before any work is spent on it).
  explicit TemporaryFile(const std::filesystem::path& target);
  ~TemporaryFile();
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  const std::filesystem::path& path() const { return temporary_; }
  const std::filesystem::path& target() const { return target_; }
  /// The whole content. Throws OutputError.
  void write(std::string_view bytes) const;
  void write(std::span<const unsigned char> bytes) const {
    write(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  /// It and its new name are on the disk when this returns. Throws OutputError.
  void commit();
  [[noreturn]] void refuse(const std::string& reason) const;  ///< throws OutputError naming the target

 private:
  struct Open {
    int descriptor = -1;
    ~Open();
  };
  Open open(int flags) const;
  [[noreturn]] void refuse(int error) const;

  std::filesystem::path target_, temporary_;
  std::uint64_t inode_ = 0;  ///< of the file that was made
};

/// What the system says of an error of opening, reading or writing (errno), and what to do: `otherwise` where
/// it is none of descriptors, sizes, memory or quota.
std::string with_remedy(int error, const std::string& otherwise);

/// Removes the unfinished files of this process, for a program that is about to end at SIGINT or SIGTERM.
/// Call it from an ordinary thread that waits for the signal (sigwait), not from a signal handler: it takes a
/// lock.
void remove_partial_files();

}  // namespace tribotrack::vision
