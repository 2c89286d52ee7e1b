// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace tribotrack::vision {

/// A name beside `target` under which a file is written; commit() renames it to `target`. Destroyed without
/// commit(), it removes what was written, as does remove_partial_files() (frame_sink.h) for all of them.
class TemporaryFile {
 public:
  /// Throws InputError where no file can be made there (and so before any work is spent on it).
  explicit TemporaryFile(std::filesystem::path target);
  ~TemporaryFile();
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  const std::filesystem::path& path() const { return temporary_; }
  const std::filesystem::path& target() const { return target_; }
  /// The whole content. Throws OutputError.
  void write(std::span<const unsigned char> bytes) const;
  /// Throws OutputError.
  void commit();
  [[noreturn]] void refuse(const std::string& reason) const;  ///< throws OutputError naming the target

 private:
  std::filesystem::path target_, temporary_;
};

}  // namespace tribotrack::vision
